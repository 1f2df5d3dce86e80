// How much of the blend loop's work a view needs: pixel and splat pairs.
#pragma once

#include <cstdint>

#include "splat/base/camera.h"
#include "splat/gaussians.h"

namespace cosplat {

struct PairCounts {
  // Pixels of the blocks that a splat reaches, while a pixel of the block still takes splats: the
  // lanes that the blend loop works on.
  uint64_t evaluated = 0;
  // Of them, those with an alpha of at least 1/255 that are not yet opaque.
  uint64_t contributing = 0;
};

// Of one view over a black background, colours of all stored bands.
PairCounts CountPairs(const Gaussians& gaussians, const Camera& camera);

}  // namespace cosplat
