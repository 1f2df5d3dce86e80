#include "splat/device/cuda/launch.cuh"
#include "splat/train/cuda/device_subject.h"

namespace cosplat::cuda {
namespace {

struct AddOffsets {
  DeviceView<const float> offsets;
  size_t first;
  DeviceView<float> position;
  __device__ void operator()(size_t k) const { position[3 * first + k] += offsets[k]; }
};

}  // namespace

void DeviceSubject::Move(DeviceView<const float> offsets,
                         size_t first,
                         DeviceGaussians& gaussians,
                         cudaStream_t stream) {
  ForEach(offsets.count, stream, AddOffsets{offsets, first, gaussians.values[kPosition].view()});
}

}  // namespace cosplat::cuda
