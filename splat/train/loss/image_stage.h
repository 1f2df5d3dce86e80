// What lies between a rendered image and its photograph, one stage after the other.
//
//   rendered image -> Forward of each stage -> loss -> Backward of each stage, in reverse order
#pragma once

#include <array>
#include <cstddef>

#include "splat/device/buffer.h"
#include "splat/train/loss/loss.h"

namespace cosplat {

struct FrameLayers;

// The frame that is drawn, in a stream's memory.
struct StageFrame {
  TargetView target;
  std::array<float, 3> background;
  const float* exposure;      // [12], or null for the identity
  const FrameLayers* layers;  // of other blocks
};

class ImageStage {
 public:
  virtual ~ImageStage() = default;
  // Whether the stage changes the frame's image; only then it is called.
  virtual bool Changes(const StageFrame& frame) const = 0;
  // image: [3, height, width]. Valid until the next call.
  virtual const Buffer<float>& Forward(View<const float> image,
                                       const StageFrame& frame,
                                       Stream& stream) = 0;
  // d: the gradient of what Forward returned, of the same arguments; turned into that of `image`,
  // in place.
  virtual void Backward(View<const float> image,
                        const StageFrame& frame,
                        Buffer<float>& d,
                        Stream& stream) = 0;
  virtual size_t allocated_bytes() const = 0;  // bytes
};

}  // namespace cosplat
