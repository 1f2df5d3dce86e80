// Copies of the host's WorldGaussians and WorldGradients in a stream's memory.
#pragma once

#include "splat/device/buffer.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat {

class WorldArrays {
 public:
  // Returns the view of what was copied.
  WorldGaussians Upload(const WorldGaussians& host, Stream& stream);

 private:
  Buffer<float> position_, rotation_, scale_log_, opacity_logit_, color_dc_, color_rest_,
      color_frame_;
  Buffer<uint8_t> degree_;
};

class WorldGradientArrays {
 public:
  // Gradients for `count` Gaussians, of the arrays that `host` has. With host.drawn_groups_only
  // what is there now is copied, so that Download brings back what was left alone.
  WorldGradients Prepare(const WorldGradients& host, size_t count, int rest_width, Stream& stream);
  // They are there when the stream has been waited for.
  void Download(const WorldGradients& host, Stream& stream) const;

 private:
  Buffer<float> position_, rotation_, scale_log_, opacity_logit_, color_dc_, color_rest_,
      color_frame_, screen_;
};

}  // namespace cosplat
