// A Gaussian's place on the canonical mesh, for density control on the CPU and on a device.
#pragma once

#include "avatar/surface/kernels/reembed.h"

namespace cosplat::math {

// Where density control finds and leaves a Gaussian.
struct PlaceOnMesh {
  int32_t* triangle;   // [1]
  float* barycentric;  // [2]
  float* offset;       // [3] (du, dv, d)
};

// barycentric: [2]; offset: [3].
COSPLAT_HD Vec3<float> CanonicalPlace(const MeshArrays& mesh,
                                      int32_t triangle,
                                      const float* barycentric,
                                      const float* offset) {
  Three<SurfaceVertex<float>> corners;
  Three<float> area;
  for (int c = 0; c < 3; ++c) {
    const float* v = CanonicalVertex(mesh, triangle, c);
    corners[c] = {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8], v[9]}, v[10]};
    area[c] = v[10];
  }
  const LocalGaussian<float> local{
      barycentric[0], barycentric[1], {offset[0], offset[1], offset[2]}, {1, 0, 0, 0}, {0, 0, 0}};
  return Embed(corners, area, local).position;
}

// Re-embeds it where it is after a move by `by` on the canonical mesh; keeps_d: with the d that it
// had. One that is not at a place or would be moved to none (its numbers are not finite) is left
// alone.
COSPLAT_HD void MoveOnMesh(const MeshArrays& mesh,
                           const Vec3<float>& by,
                           bool keeps_d,
                           const PlaceOnMesh& place,
                           FaceSearch& search) {
  const Vec3<float> p = CanonicalPlace(mesh, *place.triangle, place.barycentric, place.offset) + by;
  const Vec3<double> x{p.x, p.y, p.z};
  if (!std::isfinite(x.x + x.y + x.z)) return;
  const Reembedded found = ReembedNear(mesh, *place.triangle, x, search);
  *place.triangle = found.face;
  place.barycentric[0] = float(found.at[0]);
  place.barycentric[1] = float(found.at[1]);
  place.offset[0] = place.offset[1] = 0;
  if (!keeps_d) place.offset[2] = float(found.d);
}

}  // namespace cosplat::math
