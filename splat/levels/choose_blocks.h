// Which blocks of a scene's levels to draw for a camera: what is in the image, each part as coarse
// as cannot be seen, or as the time for an image allows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "splat/base/camera.h"
#include "splat/levels/scene_levels.h"

namespace cosplat {

struct LevelLimits {
  // px: blocks whose coarseness is smaller in the image, at the point of their box that is nearest
  // to the camera, are not refined. The default cannot be seen (docs/large-scenes.md).
  float coarseness = 0.5f;
  // Gaussians: the blocks that are coarsest in the image are refined first, until there would be
  // more. One block is drawn at least.
  size_t max = std::numeric_limits<size_t>::max();
};

// Overwrites `chosen` with indices of blocks, in ascending order; none of them stands for another.
void ChooseBlocks(const SceneLevels& levels,
                  const Camera& camera,
                  const LevelLimits& limits,
                  std::vector<uint32_t>& chosen);

}  // namespace cosplat
