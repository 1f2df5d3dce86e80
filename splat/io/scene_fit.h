// Whether images show what cameras and points say: the part of CheckScene that measures it.
#pragma once

#include <vector>

#include "splat/base/skipped.h"
#include "splat/io/dataset.h"
#include "splat/media/image_glance.h"

namespace cosplat {

// A view and its image, reduced.
struct LookedAt {
  const SceneView* view = nullptr;
  Image8 image;
  Camera camera;  // at that size
  Glance glance{};
  size_t group = 0;  // neighbours in `views` are of one group
};

// Groups of three neighbours, 24 views in all.
std::vector<LookedAt> LookAt(const std::vector<const SceneView*>& views);

// Adds what it finds.
void CheckFit(const SceneData& scene,
              const std::vector<LookedAt>& looked,
              std::vector<Finding>& findings);

}  // namespace cosplat
