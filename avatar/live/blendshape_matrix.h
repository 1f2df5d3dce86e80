// A user's own map from ARKit's blendshapes to FLAME's parameters, as a matrix in a file.
//
// matrix.npz -> ReadBlendshapeMatrix -> BlendshapeMap -> VmcSource, JsonSource.
#pragma once

#include <string>

#include "avatar/model/blendshape_map.h"

namespace cosplat {

// Reads an .npz with `expression` [52, E] and, optionally, `jaw`, `left_eye` and `right_eye`
// [52, 3], axis-angle; a joint whose array is missing does not turn. Throws Error naming file and
// array when a shape is wrong, a number is not finite, or the absolute values of a column add up to
// more than kMaxMapped.
BlendshapeMap ReadBlendshapeMatrix(const std::string& path);

}  // namespace cosplat
