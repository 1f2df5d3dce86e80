// Gaussians as attributes of a glTF points primitive with KHR_gaussian_splatting.
//
// Gaussians in the world (glTF's axes) -> AddSplats -> GlbPrimitive -> avatar/io/avatar_file.h,
// splat_file.h -> FindSplats, ReadSplatPrimitive -> Gaussians. Attributes, all float: POSITION;
// KHR_gaussian_splatting:ROTATION (xyzw, unit), :SCALE (linear), :OPACITY (0 to 1),
// :SH_DEGREE_l_COEF_n (VEC3, the signs and constants of 3DGS). Kernel ellipse, colour space
// srgb_rec709_display, projection perspective, sorted by cameraDistance. The extension's
// extras.antialiased, true or absent, is Gaussians::antialiased, extras.low_pass_variance its
// filter's. Source: Khronos, KHR_gaussian_splatting.
#pragma once

#include <string>

#include "splat/gaussians.h"
#include "splat/io/glb.h"
#include "splat/io/splat_file.h"

namespace cosplat {

inline constexpr const char* kSplatExtension = "KHR_gaussian_splatting";

// "KHR_gaussian_splatting:SH_DEGREE_l_COEF_n" of coefficient k = l^2 + n.
std::string SplatCoefficientName(int coefficient);

// Adds the accessors to `document` and returns the primitive. gaussians: any basis, kPosition in
// the world. One without a direction becomes transparent (splat/io/splat_values.h). Throws Error if
// there are no Gaussians, for a number that is not finite after conversion, and for a degree above
// 3 unless `truncate_degree`, which drops the bands above 3.
GlbPrimitive AddSplats(GlbDocument& document, const Gaussians& gaussians, bool truncate_degree);

// The document's only KHR_gaussian_splatting primitive. Throws Error when there is none or more
// than one.
const GlbPrimitive& FindSplats(const GlbDocument& document);

// The Gaussians of that primitive, in 3DGS's SH and its own axes, settled
// (splat/io/splat_values.h). Opacities 0 and 1 become finite logits; where a scale is negative all
// are logarithms (splat-transform issue 267). Throws Error naming the attribute if one is missing,
// is not of floats or has another length, and for an opacity outside 0..1.
Gaussians ReadSplatPrimitive(const GlbDocument& document,
                             const GlbPrimitive& primitive,
                             std::vector<std::string>* notes = nullptr);

// The sign by which TurnToGltfAxes multiplies coefficient k = l^2 + l + m of either basis, so that
// the colour seen along the rotated direction is that seen along the original one. Y_l^m(x, -y, -z)
// = (-1)^(l + m) Y_l^m for m >= 0 and -(-1)^(l + m) Y_l^m for m < 0: -1 for k = 1, 2, 4, 7, 9, 11,
// 12, 14 up to degree 3.
float GltfTurnSign(int coefficient);

}  // namespace cosplat
