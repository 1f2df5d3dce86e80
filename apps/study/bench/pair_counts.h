// How much work a view needs: of the blend loop, pixel and splat pairs; of the optimiser,
// Gaussians.
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

// Share of the Gaussians (at least 1) whose groups a step on this view updates with AdamOn::kDrawn.
double AdamShare(const Gaussians& gaussians, const Camera& camera);

}  // namespace cosplat
