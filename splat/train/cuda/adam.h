// Adam on the device over the Gaussians that were drawn: splat/train/optimizer.h there, with what
// it puts off for the others.
#pragma once

#include "splat/render/cuda/device_gaussians.h"
#include "splat/train/optimizer.h"

namespace cosplat::cuda {

class Adam {
 public:
  // Moments of zero for Gaussians of this layout, and nothing put off.
  void Start(const DeviceGaussians& values, cudaStream_t stream);

  // As AdamStepAll, on the groups of which a Gaussian was drawn. radii: [N]; empty: all groups.
  // position_rate_scale: [N, 3] or null.
  void Step(const AdamSettings& settings,
            const DeviceGaussians& gradients,
            DeviceView<const float> radii,
            const float* position_rate_scale,
            DeviceGaussians& values,
            cudaStream_t stream);
  // As AdamCatchUpAll.
  void CatchUpAll(const AdamSettings& settings,
                  const float* position_rate_scale,
                  DeviceGaussians& values,
                  cudaStream_t stream);

  // Gradients so far that were not finite; the host waits.
  uint32_t IgnoredGradients(cudaStream_t stream) { return readback_.Get(ignored_.data(), stream); }

  DeviceGaussians m, v;
  DeviceBuffer<uint32_t> updated;  // [groups] the step that each was last brought to
  uint32_t step = 0;
  // On the device, where not null: while it is not 0 there, Step changes nothing but `step`.
  const uint32_t* overflowed = nullptr;

 private:
  void Update(const AdamSettings& settings,
              const DeviceGaussians* gradients,
              const float* position_rate_scale,
              DeviceGaussians& values,
              cudaStream_t stream);

  DeviceBuffer<uint32_t> behind_;   // [groups] steps to make up for, or kNotNow (adam.cu)
  DeviceBuffer<uint32_t> ignored_;  // [1]
  Readback<uint32_t> readback_;
};

}  // namespace cosplat::cuda
