#include "splat/device/cuda/gather_rows.cuh"
#include "splat/train/cuda/population.h"

namespace cosplat::cuda {
namespace {

void GatherAll(DeviceGaussians& gaussians,
               DeviceGaussians& spare,
               DeviceView<const uint32_t> source,
               size_t first_zero,
               cudaStream_t stream) {
  for (int a = 0; a < kAttributeCount; ++a)
    GatherArray(gaussians.values[a],
                spare.values[a],
                size_t(gaussians.width(a)),
                source,
                first_zero,
                stream);
}

struct FillNumbers {
  DeviceView<uint32_t> numbers;
  uint32_t value;
  __device__ void operator()(size_t i) const { numbers[i] = value; }
};

}  // namespace

void Population::Gather(DeviceView<const uint32_t> source,
                        size_t first_fresh,
                        cudaStream_t stream) {
  const size_t n = source.count;
  GatherAll(values, gradients, source, n, stream);
  GatherAll(adam.m, gradients, source, first_fresh, stream);
  GatherAll(adam.v, gradients, source, first_fresh, stream);
  gradients.ResizeLike(values);
  if (!values.degrees.empty()) GatherArray(values.degrees, spare_degrees_, 1, source, n, stream);
  for (DeviceBuffer<float>* b : statistics.all())
    GatherArray(*b, spare_, 1, source, first_fresh, stream);
  mask.Gather(source, first_fresh, stream);
  adam.updated.Refill(AdamGroupCount(n));
  ForEach(adam.updated.size(), stream, FillNumbers{adam.updated.view(), adam.step});
}

}  // namespace cosplat::cuda
