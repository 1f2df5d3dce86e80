// The SSIM window over a tile of pixels: along rows, then down columns, in shared memory.
#pragma once

#include "splat/device/cuda/launch.cuh"
#include "splat/math/photometric.h"
#include "splat/math/ssim.h"

namespace cosplat::cuda {

constexpr int kLossSide = 16;                                 // of a tile, px
constexpr int kLossHalo = kLossSide + 2 * math::kSsimRadius;  // tile and window border
constexpr unsigned kLossThreads = kLossSide * kLossSide;      // one per pixel of the tile

// Values of a tile's pixels and of the border around it; and windowed sums along its rows.
using HaloPlane = float[kLossHalo][kLossHalo + 1];
using AlongPlane = float[kLossHalo][kLossSide];

struct SsimWeights {
  float w[math::kSsimRadius + 1];
};

// The windowed sum around *middle of the values or their squares; neighbours are `stride` apart.
__device__ inline float Weigh(const SsimWeights& window, const float* middle, int stride) {
  float sum = window.w[0] * middle[0];
  for (int k = 1; k <= math::kSsimRadius; ++k)
    sum += window.w[k] * (middle[-k * stride] + middle[k * stride]);
  return sum;
}
__device__ inline float WeighSquares(const SsimWeights& window, const float* middle) {
  float sum = window.w[0] * (middle[0] * middle[0]);
  for (int k = 1; k <= math::kSsimRadius; ++k)
    sum += window.w[k] * (middle[-k] * middle[-k] + middle[k] * middle[k]);
  return sum;
}

// One tile of one channel: one thread block per tile, row by row, then channel by channel.
struct LossTile {
  int channel, x0, y0;
  __device__ LossTile(int width, int height) {
    const unsigned across = (width + kLossSide - 1) / kLossSide;
    const unsigned tiles = across * ((height + kLossSide - 1) / kLossSide);
    const unsigned tile = blockIdx.x % tiles;
    channel = int(blockIdx.x / tiles);
    x0 = int(tile % across) * kLossSide;
    y0 = int(tile / across) * kLossSide;
  }
  __device__ int column() const { return int(threadIdx.x) % kLossSide; }
  __device__ int row() const { return int(threadIdx.x) / kLossSide; }
  __device__ int x() const { return x0 + column(); }
  __device__ int y() const { return y0 + row(); }

  // Calls f(row, column, x, y) for all pixels that the window reaches, also outside the image.
  template <class F>
  __device__ void ForHalo(const F& f) const {
    for (int i = int(threadIdx.x); i < kLossHalo * kLossHalo; i += int(kLossThreads)) {
      const int r = i / kLossHalo, c = i % kLossHalo;
      f(r, c, x0 + c - math::kSsimRadius, y0 + r - math::kSsimRadius);
    }
  }
  // Calls f(row, column) for each element of an AlongPlane.
  template <class F>
  __device__ void ForAlong(const F& f) const {
    for (int i = int(threadIdx.x); i < kLossHalo * kLossSide; i += int(kLossThreads))
      f(i / kLossSide, i % kLossSide);
  }
};

// The rendered image and the target image; target bytes are composited over the background on
// reading.
struct ComparedImages {
  const float* rendered;  // [3, height, width]
  const uint8_t* target;  // [height, width, channels]
  int width, height, channels;
  float background[3];

  __device__ bool Contains(int x, int y) const {
    return x >= 0 && x < width && y >= 0 && y < height;
  }
  __device__ size_t At(int channel, int x, int y) const {
    return (size_t(channel) * height + y) * width + x;
  }
  __device__ float Target(int channel, int x, int y) const {
    const uint8_t* p = target + (size_t(y) * width + x) * channels;
    const uint8_t value = p[channels == 1 ? 0 : channel];
    if (channels != 4) return math::FromByte(value);
    // Not background[channel]: a non-constant index would move the array to memory.
    const float behind = channel == 0   ? background[0]
                         : channel == 1 ? background[1]
                                        : background[2];
    return math::Over(value, p[3], behind);
  }
};

// Sum of one value per thread over the block, in a fixed order: within warps as T, then as doubles.
// Valid in the first thread. All threads must call it.
struct BlockSumScratch {
  double of_warp[kLossThreads / kWarp];
};
template <class T>
__device__ double BlockSum(T value, BlockSumScratch& scratch) {
  for (unsigned by = kWarp / 2; by > 0; by /= 2) value += __shfl_down_sync(kAllLanes, value, by);
  if (Lane() == 0) scratch.of_warp[WarpInBlock()] = double(value);
  __syncthreads();
  double sum = 0;
  if (threadIdx.x == 0)
    for (const double w : scratch.of_warp) sum += w;
  return sum;
}

}  // namespace cosplat::cuda
