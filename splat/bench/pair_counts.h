// How much of the blend loop's work a view needs: pixel and splat pairs.
#pragma once

#include <cstdint>

#include "splat/base/camera.h"
#include "splat/gaussians.h"

namespace cosplat {

struct PairCounts {
  uint64_t evaluated =
      0;  // pixels in the box of a splat that its tile came to before it was opaque
  uint64_t contributing = 0;  // of them, those with an alpha of at least 1/255 before the pixel is
};

// Of one view over a black background, colours of all stored bands.
PairCounts CountPairs(const Gaussians& gaussians, const Camera& camera);

}  // namespace cosplat
