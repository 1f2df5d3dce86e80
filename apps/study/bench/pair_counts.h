// Work required by a view: pixel-splat pairs in the blend loop, and Gaussians in the optimiser.
#pragma once

#include <cstdint>

#include "splat/base/camera.h"
#include "splat/gaussians.h"

namespace cosplat {

struct PairCounts {
  // Pixels of the blocks that a splat reaches, while any pixel of the block still accepts splats:
  // the lanes that the blend loop processes.
  uint64_t evaluated = 0;
  // Those with an alpha of at least 1/255, at pixels that are not yet opaque.
  uint64_t contributing = 0;
};

// One view over a black background, with all stored colour bands.
PairCounts CountPairs(const Gaussians& gaussians, const Camera& camera);

// Share of the Gaussians (at least 1) in groups that a step on this view updates with
// AdamOn::kDrawn.
double AdamShare(const Gaussians& gaussians, const Camera& camera);

}  // namespace cosplat
