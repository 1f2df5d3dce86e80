// Sampling of initial Gaussians on the canonical mesh, and embedding of points near it.
//
// CanonicalMesh -> SampleSurface -> a new AvatarModel's triangles and barycentrics; density
// control: a split Gaussian's canonical position -> Reembed -> its triangle, barycentrics and
// offset d.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "avatar/surface/surface.h"
#include "splat/base/rng.h"

namespace cosplat {

// n points spread evenly over the area: stratified into n strata of equal area, in face order,
// uniform within each. A face with a fraction a of the area gets between floor(n a) - 1 and
// ceil(n a) + 1 points. The same state of `rng` gives the same bits on all platforms. Throws Error
// when the mesh has no area or a face refers to a vertex that does not exist.
std::vector<SurfacePoint> SampleSurface(const CanonicalMesh& mesh, size_t n, Rng& rng);

// n points as the released SplattingAvatar initialises them: each on a face chosen uniformly,
// whatever its area, and uniform inside it. The same state of `rng` gives the same bits on all
// platforms. Throws Error when the mesh has no faces.
std::vector<SurfacePoint> SampleFaces(const CanonicalMesh& mesh, size_t n, Rng& rng);

struct EmbeddedPoint {
  SurfacePoint base;
  float d = 0;         // along the interpolated normal, metres
  float residual = 0;  // distance of the embedded point from the requested one, metres
};

// Embeds `point` (canonical frame, metres) near face `start`: solves P(b) + d n(b) = point with the
// interpolated normal n, starting at the closest point of the faces around `start`. If there is no
// solution on the mesh (beyond a boundary, far from the surface), the closest point is used, with d
// the offset along its normal; the residual is the remaining error. Never leaves the connected
// component of `start`; the work is bounded. Throws Error when `start` does not exist or `point` is
// not finite.
EmbeddedPoint Reembed(const Surface& surface, const std::array<float, 3>& point, int32_t start);

}  // namespace cosplat
