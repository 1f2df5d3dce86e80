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
#include "splat/io/splat_file.h"

namespace cosplat {

inline constexpr const char* kSplatExtension = "KHR_gaussian_splatting";

// "KHR_gaussian_splatting:SH_DEGREE_l_COEF_n" of coefficient k = l^2 + n.
std::string SplatCoefficientName(int coefficient);

// Adds the accessors to `document` and returns the primitive.
// gaussians: any basis, kPosition in the world. A rotation without a direction becomes the
// identity. Throws Error for no Gaussians, for a number that is not finite once converted, and for
// a degree above 3 unless `truncate_degree`: then the bands above 3 are left out.
GlbPrimitive AddSplats(GlbDocument& document, const Gaussians& gaussians, bool truncate_degree);

// From OpenCV's axes to glTF's: half a turn about x.
//
// Scenes keep the world of their data, which for COLMAP's and most others' is OpenCV's manner: x
// right, y down, z away from the first camera. glTF has y up and z towards the viewer. The turn
// (x, y, z) -> (x, -y, -z) carries the one into the other and keeps right-handedness.
// FLAME's own axes (y up, the face towards +z, metres) are glTF's already: avatars are not turned.

// +1 or -1: what coefficient k = l^2 + l + m of either basis is multiplied by, so that the colour
// seen along the turned direction is the one that was seen along the direction before.
// Y_l^m(x, -y, -z) = (-1)^(l + m) Y_l^m for m >= 0 and -(-1)^(l + m) Y_l^m for m < 0: -1 for
// k = 1, 2, 4, 7, 9, 11, 12, 14 up to degree 3.
float GltfTurnSign(int coefficient);

// Turns positions, rotations and colours. kPosition must be points in the world.
// Turning twice gives the same Gaussians (rotations up to their sign).
void TurnToGltfAxes(Gaussians& gaussians);

}  // namespace cosplat
