#include <cfloat>

#include "splat/device/cuda/launch.cuh"
#include "splat/train/cuda/density.h"

namespace cosplat::cuda {
namespace {

// Lowest and highest corner.
struct Box {
  float low[3], high[3];
  __device__ void Clear() {
    for (int k = 0; k < 3; ++k) low[k] = FLT_MAX, high[k] = -FLT_MAX;
  }
  __device__ void Add(const Box& b) {
    for (int k = 0; k < 3; ++k) {
      low[k] = math::Min(low[k], b.low[k]);
      high[k] = math::Max(high[k], b.high[k]);
    }
  }
};

// The box of each block's 256 points, or of all of its boxes; of what is not finite nothing.
template <bool kOfPoints>
struct FindBoxes {
  static constexpr unsigned kThreads = 256;
  DeviceView<const float> from;  // [n, 3] points; or [n, 6] boxes, by one block
  size_t n;
  DeviceView<float> to;  // [blocks, 6]

  struct Shared {
    Box of_thread[kThreads];
  };
  __device__ void operator()() const {
    Shared& s = SharedMemory<Shared>();
    Box& mine = s.of_thread[threadIdx.x];
    mine.Clear();
    const size_t first = size_t(blockIdx.x) * kThreads + threadIdx.x;
    for (size_t i = first; i < n; i += kOfPoints ? n : kThreads) mine.Add(BoxOf(i));
    __syncthreads();
    if (threadIdx.x != 0) return;
    for (unsigned t = 1; t < kThreads; ++t) mine.Add(s.of_thread[t]);
    for (int k = 0; k < 3; ++k) {
      to[6 * blockIdx.x + k] = mine.low[k];
      to[6 * blockIdx.x + 3 + k] = mine.high[k];
    }
  }
  __device__ Box BoxOf(size_t i) const {
    Box box;
    box.Clear();
    const float* p = &from[(kOfPoints ? 3 : 6) * i];
    if (kOfPoints && !math::IsFinitePoint(p)) return box;
    for (int k = 0; k < 3; ++k) {
      box.low[k] = p[k];
      box.high[k] = p[kOfPoints ? k : 3 + k];
    }
    return box;
  }
};

// Sorted by the lower half of the codes first, then, stably, by the upper.
struct LowKeys {
  DeviceView<const float> position, box;
  DeviceView<uint64_t> codes;
  DeviceView<uint32_t> keys, gaussians;
  __device__ void operator()(size_t i) const {
    codes[i] = math::MortonCode(&position[3 * i], &box[0], &box[3]);
    keys[i] = uint32_t(codes[i]);
    gaussians[i] = uint32_t(i);
  }
};
struct HighKeys {
  DeviceView<const uint64_t> codes;
  DeviceView<const uint32_t> gaussians;
  DeviceView<uint32_t> keys;
  __device__ void operator()(size_t k) const { keys[k] = uint32_t(codes[gaussians[k]] >> 32); }
};

}  // namespace

void DensityControl::SortInSpace(Population& population, cudaStream_t stream) {
  const size_t n = population.size();
  const DeviceView<const float> position = placement_.Centers(population.values, stream);
  constexpr size_t kThreads = FindBoxes<true>::kThreads;
  const size_t blocks = (n + kThreads - 1) / kThreads;
  boxes_.Refill(6 * (blocks + 1));
  const DeviceView<float> parts{boxes_.data(), 6 * blocks}, whole{boxes_.data() + 6 * blocks, 6};
  ForBlocks(blocks, stream, FindBoxes<true>{position, n, parts});
  ForBlocks(1, stream, FindBoxes<false>{{parts.data, parts.count}, blocks, whole});
  codes_.Refill(n);
  order_.Refill(n);
  ForEach(n,
          stream,
          LowKeys{position,
                  {whole.data, whole.count},
                  codes_.view(),
                  order_.keys.view(),
                  order_.values.view()});
  sorter_.Sort(order_, 32, stream);
  ForEach(
      n,
      stream,
      HighKeys{
          std::as_const(codes_).view(), std::as_const(order_.values).view(), order_.keys.view()});
  sorter_.Sort(order_, 32, stream);
  Gather(population, std::as_const(order_.values).view(), n, stream);
}

}  // namespace cosplat::cuda
