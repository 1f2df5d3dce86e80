// Warp-wide walks over buckets. A bucket is 32 consecutive instances of a tile, one per lane; a
// walk visits all pixels of the tile.
//
// Pixels are pipelined through the lanes: in step s, lane l processes pixel s - l, whose state has
// already passed through the preceding lanes, which hold the splats in front of its own. Each lane
// therefore visits all pixels for its own splat and accumulates that splat's sum over the tile by
// itself, in one fixed order. Buckets start from the pixel states that the forward pass stored
// (PixelCheckpoint) and are independent of each other. Source: Mallick et al. 2024 (Taming 3DGS).
#pragma once

#include "splat/render/cuda/blend.cuh"
#include "splat/render/cuda/tape.h"

namespace cosplat::cuda {

// Lists and images that every walk needs.
struct BucketLists {
  TileListsView lists;
  View<const ProjectedSplat> splats;
  View<const uint32_t> n_contrib;
  View<const PixelCheckpoint> checkpoints;
  View<const float> color;  // [3, height, width] the rendered image
  int width, height;
};

BucketLists BucketListsOf(const CudaTape& tape, const RenderedImage& image);

// A Walk defines
//   Pixel      per-pixel data in shared memory, as of the start of the bucket
//   State      the part of it that splats change
//   Sum        what is accumulated per splat
//   Load       returns the Pixel of a pixel inside the image
//   Outside    returns the Pixel of one outside it, which accepts no splats
//   StartOf    returns a Pixel's initial State
//   Step       processes a pixel that accepts the splat
//   Finish     called once per instance; with a zero Sum if the instance was not processed
template <class Walk>
struct BucketKernel {
  static constexpr unsigned kThreads = 128;
  static constexpr unsigned kWarps = kThreads / kWarp;
  BucketLists in;
  Walk walk;

  using Pixel = typename Walk::Pixel;
  using State = typename Walk::State;
  struct Shared {
    Pixel pixels[kWarps][kTilePixels];
  };

  // Uses no block-wide barriers: warps are independent.
  __device__ void operator()() const {
    const uint64_t bucket = uint64_t(blockIdx.x) * kWarps + WarpInBlock();
    const int tiles = int(in.n_contrib.count);
    if (bucket >= in.lists.bucket_begin[tiles]) return;
    const int tile = TileOf(bucket, tiles);
    const uint32_t first = uint32_t(bucket - in.lists.bucket_begin[tile]) * kBucket;
    const uint32_t k = in.lists.tile_begin[tile] + first + Lane();
    const bool mine = k < in.lists.tile_begin[tile + 1];
    const uint32_t gaussian = mine ? in.lists.gaussian[k] : 0;
    BlendSplat splat{};
    if (mine) splat = BlendSplat(in.splats[gaussian]);
    typename Walk::Sum sum{};
    if (first < in.n_contrib[tile]) {
      const TilePixels pixels(tile, in.lists.tiles_x);
      Pixel* shared = SharedMemory<Shared>().pixels[WarpInBlock()];
      LoadPixels(bucket, pixels, shared);
      PassPixels(pixels, shared, splat, mine, sum);
    }
    if (mine) walk.Finish(k, gaussian, splat, sum);
  }

  // The last tile whose first bucket is at or before `bucket`.
  __device__ int TileOf(uint64_t bucket, int tiles) const {
    int low = 0, high = tiles;  // bucket_begin[low] <= bucket < bucket_begin[high]
    while (high - low > 1) {
      const int middle = low + (high - low) / 2;
      if (in.lists.bucket_begin[middle] <= bucket)
        low = middle;
      else
        high = middle;
    }
    return low;
  }

  __device__ void LoadPixels(uint64_t bucket, const TilePixels& pixels, Pixel* shared) const {
    const size_t plane = size_t(in.width) * in.height;
    for (int p = int(Lane()); p < kTilePixels; p += int(kWarp)) {
      const int x = pixels.x(p), y = pixels.y(p);
      if (x < in.width && y < in.height)
        shared[p] = walk.Load(
            in, plane, size_t(y) * in.width + x, in.checkpoints[bucket * kTilePixels + p]);
      else
        shared[p] = Walk::Outside();
    }
    __syncwarp();
  }

  __device__ void PassPixels(const TilePixels& pixels,
                             const Pixel* shared,
                             const BlendSplat& splat,
                             bool mine,
                             typename Walk::Sum& sum) const {
    State state{};
    for (int step = 0; step < kTilePixels + int(kWarp) - 1; ++step) {
      state = state.FromLaneBefore();
      const int p = step - int(Lane());
      if (p < 0 || p >= kTilePixels) continue;
      const Pixel& pixel = shared[p];
      if (Lane() == 0) state = Walk::StartOf(pixel);
      if (!mine) continue;
      const float dx = pixels.x(p) + 0.5f - splat.x, dy = pixels.y(p) + 0.5f - splat.y;
      const float power = PowerAt(splat.form(), dx, dy);
      if (math::Accepts(power, splat.reject_below, state.transmittance))
        walk.Step(pixel, splat, dx, dy, Falloff(power), state, sum);
    }
  }
};

template <class Walk>
void WalkBuckets(const CudaTape& tape,
                 const RenderedImage& image,
                 const Walk& walk,
                 Stream& stream) {
  using Kernel = BucketKernel<Walk>;
  if (tape.lists.capacity() == 0) return;
  const size_t blocks = (tape.lists.most_buckets() + Kernel::kWarps - 1) / Kernel::kWarps;
  ForBlocks(blocks, stream, Kernel{BucketListsOf(tape, image), walk});
}

}  // namespace cosplat::cuda
