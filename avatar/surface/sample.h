// Where Gaussians begin on the canonical mesh, and where a point near it is to be embedded.
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

// n points spread evenly over the area: one in each of n strata of equal area, taken in the order
// of the faces, uniform inside it. A face of share a of the area gets between floor(n a) - 1 and
// ceil(n a) + 1 of them. Same bits for the same state of `rng` anywhere. Throws Error when the mesh
// has no area or a face names a vertex that does not exist.
std::vector<SurfacePoint> SampleSurface(const CanonicalMesh& mesh, size_t n, Rng& rng);

// n points, each on a face drawn from all alike, whatever its area, and uniform inside it: how the
// released SplattingAvatar begins. Same bits for the same state of `rng` anywhere. Throws Error
// when the mesh has no faces.
std::vector<SurfacePoint> SampleFaces(const CanonicalMesh& mesh, size_t n, Rng& rng);

struct EmbeddedPoint {
  SurfacePoint base;
  float d = 0;         // along the interpolated normal, metres
  float residual = 0;  // distance of the embedded point from the one asked for, metres
};

// Embeds `point` (canonical frame, metres) near face `start`: solves P(b) + d n(b) = point with the
// interpolated normal n, beginning at the closest point of the faces around `start`. Where there is
// no solution on the mesh (beyond a boundary, far from the surface) the closest point is taken,
// with d the offset along its normal, and the residual says how much is lost. Never leaves the
// connected component of `start`; bounded work. Throws Error when `start` does not exist or `point`
// is not finite.
EmbeddedPoint Reembed(const Surface& surface, const std::array<float, 3>& point, int32_t start);

}  // namespace cosplat
