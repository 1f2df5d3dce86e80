// Copies of WorldGaussians and WorldGradients from host memory in a stream's memory.
#pragma once

#include "splat/device/buffer.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat {

class WorldArrays {
 public:
  // Returns a view of the copy.
  WorldGaussians Upload(const WorldGaussians& host, Stream& stream);

 private:
  Buffer<float> position_, rotation_, scale_log_, opacity_logit_, color_dc_, color_rest_,
      color_frame_, smoothing_;
  Buffer<uint8_t> degree_;
};

class WorldGradientArrays {
 public:
  // Allocates gradients for `count` Gaussians, for the arrays that are not null in `host`. With
  // host.drawn_groups_only, copies the current values, so that Download keeps those of skipped
  // groups.
  WorldGradients Prepare(const WorldGradients& host, size_t count, int rest_width, Stream& stream);
  // Complete once the stream has been waited for.
  void Download(const WorldGradients& host, Stream& stream) const;

 private:
  Buffer<float> position_, rotation_, scale_log_, opacity_logit_, color_dc_, color_rest_,
      color_frame_, screen_;
};

}  // namespace cosplat
