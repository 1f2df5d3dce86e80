// Gaussians as the attributes of a glTF points primitive with KHR_gaussian_splatting.
//
// Gaussians in the world (glTF's axes) -> AddSplats -> GlbPrimitive -> avatar/io/avatar_file.h,
// scene_glb.h. Attributes, all float: POSITION; KHR_gaussian_splatting:ROTATION (xyzw, unit),
// :SCALE (linear), :OPACITY (0 to 1), :SH_DEGREE_l_COEF_n (VEC3, the signs and constants of 3DGS).
// Kernel ellipse, colour space srgb_rec709_display, projection perspective, sorted by
// cameraDistance. Source: Khronos, KHR_gaussian_splatting.
#pragma once

#include <string>

#include "splat/gaussians.h"
#include "splat/io/glb.h"
#include "splat/io/scene_glb.h"

namespace cosplat {

inline constexpr const char* kSplatExtension = "KHR_gaussian_splatting";

// "KHR_gaussian_splatting:SH_DEGREE_l_COEF_n" of coefficient k = l^2 + n.
std::string SplatCoefficientName(int coefficient);

// Adds the accessors to `document` and returns the primitive.
// gaussians: any basis, kPosition in the world. A rotation without a direction becomes the
// identity. Throws Error for no Gaussians, for a number that is not finite once converted, and for
// a degree above 3 unless `truncate_degree`: then the bands above 3 are left out.
GlbPrimitive AddSplats(GlbDocument& document, const Gaussians& gaussians, bool truncate_degree);

}  // namespace cosplat
