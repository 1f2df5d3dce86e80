// Positions of Gaussians on the canonical mesh, for density control on the CPU and on a device.
#pragma once

#include "avatar/surface/kernels/reembed.h"

namespace cosplat::math {

// Pointers to a Gaussian's embedding, which density control reads and updates.
struct PlaceOnMesh {
  int32_t* triangle;   // [1]
  float* barycentric;  // [2]
  float* offset;       // [3] (du, dv, d)
};

// The position in the canonical frame. barycentric: [2]; offset: [3].
COSPLAT_HD Vec3<float> CanonicalPlace(const MeshArrays& mesh,
                                      int32_t triangle,
                                      const float* barycentric,
                                      const float* offset) {
  Three<SurfaceVertex<float>> corners;
  Three<float> area;
  for (int c = 0; c < 3; ++c) {
    corners[c] = CanonicalVertex(mesh, triangle, c);
    area[c] = corners[c].area;
  }
  const EmbeddedGaussian<float> local{
      barycentric[0], barycentric[1], {offset[0], offset[1], offset[2]}, {1, 0, 0, 0}, {0, 0, 0}};
  return Embed(corners, area, local).position;
}

// Moves a Gaussian by `by` in the canonical frame and re-embeds it; with keeps_d it keeps its d. A
// Gaussian whose position before or after the move is not finite is left unchanged.
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
  place.barycentric[0] = float(found.barycentric[0]);
  place.barycentric[1] = float(found.barycentric[1]);
  place.offset[0] = place.offset[1] = 0;
  if (!keeps_d) place.offset[2] = float(found.d);
}

}  // namespace cosplat::math

namespace cosplat {

// One searcher per index, because each search needs 12 kB. Searcher s takes the children s, s +
// searches.count, ...
struct MoveEach {
  MeshArrays mesh;
  View<const float> offsets;  // [children, 3]
  size_t first;               // index of the first child among the Gaussians
  bool keeps_d;
  View<math::FaceSearch> searches;
  int32_t* triangle;
  float* barycentric;
  View<float> position;
  COSPLAT_HD void operator()(size_t s) const {
    for (size_t c = s; 3 * c < offsets.count; c += searches.count) {
      const size_t i = first + c;
      math::MoveOnMesh(mesh,
                       {offsets[3 * c], offsets[3 * c + 1], offsets[3 * c + 2]},
                       keeps_d,
                       {triangle + i, barycentric + 2 * i, &position[3 * i]},
                       searches[s]);
    }
  }
};

// Kernels with one Gaussian per index.

struct PlaceEach {
  MeshArrays mesh;
  const int32_t* triangle;
  const float* barycentric;
  View<const float> position;
  View<float> centers;
  COSPLAT_HD void operator()(size_t i) const {
    const math::Vec3<float> p =
        math::CanonicalPlace(mesh, triangle[i], barycentric + 2 * i, &position[3 * i]);
    centers[3 * i] = p.x;
    centers[3 * i + 1] = p.y;
    centers[3 * i + 2] = p.z;
  }
};

struct RateEach {
  View<const float> face_rates;
  const int32_t* triangle;
  View<float> rates;  // [N, 3]
  COSPLAT_HD void operator()(size_t i) const {
    rates[3 * i] = rates[3 * i + 1] = face_rates[size_t(triangle[i])];
    rates[3 * i + 2] = 1;
  }
};

// Shrinks the bases of corrections.
struct ScaleEach {
  View<float> numbers;
  float factor;
  COSPLAT_HD void operator()(size_t i) const { numbers[i] *= factor; }
};

}  // namespace cosplat
