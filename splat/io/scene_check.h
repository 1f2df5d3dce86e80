// Whether a scene's images, cameras and points tell one story: what would train into something
// wrong without an error.
//
// SceneData -> CheckScene -> `cosplat check`, and the block before the first step of training.
#pragma once

#include <vector>

#include "splat/base/skipped.h"
#include "splat/io/dataset.h"

namespace cosplat {

// Looks at 24 views at most: few views, cameras in one spot, images without content, test images
// that are training images, views that see no points, and images that fit the points (of renderings
// with alpha: whose silhouettes fit each other) no better than those of other views, mirrored ones
// or those of another focal length do. Images that cannot be used are noted and left out, as in
// training. Throws Error as CheckSkipped does if there are no others, or all views were looked at.
std::vector<Finding> CheckScene(const SceneData& scene);

}  // namespace cosplat
