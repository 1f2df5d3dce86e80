// The 3D smoothing filter of anti-aliased training (Yu et al. 2024, Mip-Splatting), found for each
// Gaussian of a scene that does not move.
#pragma once

#include "splat/device/buffer.h"
#include "splat/gaussians.h"
#include "splat/math/pinhole.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

class SamplingFilter {
 public:
  // Sets gaussians.smoothing, from the positions and the cameras of all the subject's frames.
  void Find(const Subject& subject, Gaussians& gaussians, Stream& stream);

 private:
  Buffer<math::Pinhole<float>> views_;  // [frames] once Find was called
};

}  // namespace cosplat
