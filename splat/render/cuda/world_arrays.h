// Copies of WorldGaussians and WorldGradients on the device.
#pragma once

#include "splat/device/cuda/memory.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat::cuda {

class WorldArrays {
 public:
  // Returns the view of what was copied.
  WorldGaussians Upload(const WorldGaussians& host, cudaStream_t stream);

 private:
  DeviceBuffer<float> position_, rotation_, scale_log_, opacity_logit_, color_dc_, color_rest_,
      color_frame_;
  DeviceBuffer<uint8_t> degree_;
};

class WorldGradientArrays {
 public:
  // Gradients for `count` Gaussians, of the arrays that `host` has. With host.drawn_groups_only
  // what is there now is copied, so that Download brings back what was left alone.
  WorldGradients Prepare(const WorldGradients& host,
                         size_t count,
                         int rest_width,
                         cudaStream_t stream);
  // They are there when the stream has been waited for.
  void Download(const WorldGradients& host, cudaStream_t stream) const;

 private:
  DeviceBuffer<float> position_, rotation_, scale_log_, opacity_logit_, color_dc_, color_rest_,
      color_frame_, screen_;
};

}  // namespace cosplat::cuda
