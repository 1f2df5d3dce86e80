#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/viewer/mesh_view.h"
#include "splat/basis_constants.h"
#include "splat/config.h"
#include "splat/math/gaussian.h"

namespace cosplat::viewer {
namespace {

using math::Mat3;
using math::Vec3;

constexpr float kFaintestLogit = -2.1972246f;  // opacity 0.1

// An ellipsoid in the camera's axes and its bounding box in the image, in samples.
struct Ellipsoid {
  Mat3<float> sphere_from_cam;  // p -> unit sphere around the centre
  Vec3<float> center;           // the centre, transformed by sphere_from_cam
  float min_x, max_x, min_y, max_y;
  float nearest;  // depth
  Rgb color;
};

// Slopes along axis k (0: x, 1: y) of the planes through the eye that touch the ellipsoid: the
// roots of (Szz - z^2) u^2 - 2 (Skz - k z) u + (Skk - k^2) = 0. The discriminant is expanded, as S
// would be lost in rounding next to the squares of k and z.
struct Slopes {
  float min, max;
};
Slopes TouchingSlopes(float skk, float skz, float szz, float k, float z) {
  const float square = z * z * skk - 2 * k * z * skz + k * k * szz - (skk * szz - skz * skz);
  const float root = std::sqrt(std::max(square, 0.0f)), over = z * z - szz;
  return {(k * z - skz - root) / over, (k * z - skz + root) / over};
}

// Columns of `axes` are the half axes. Returns false if the ellipsoid reaches behind the camera or
// lies outside the image.
bool BoxOf(const Mat3<float>& axes, const Vec3<float>& c, const Camera& camera, Ellipsoid& e) {
  const auto entry = [&](int i, int k) {
    return axes(i, 0) * axes(k, 0) + axes(i, 1) * axes(k, 1) + axes(i, 2) * axes(k, 2);
  };
  const float szz = entry(2, 2);
  e.nearest = c.z - std::sqrt(szz);
  if (!(e.nearest > camera.near_plane)) return false;
  const Slopes x = TouchingSlopes(entry(0, 0), entry(0, 2), szz, c.x, c.z);
  const Slopes y = TouchingSlopes(entry(1, 1), entry(1, 2), szz, c.y, c.z);
  e.min_x = camera.fx * x.min + camera.cx;
  e.max_x = camera.fx * x.max + camera.cx;
  e.min_y = camera.fy * y.min + camera.cy;
  e.max_y = camera.fy * y.max + camera.cy;
  return e.max_x > 0 && e.max_y > 0 && e.min_x < float(camera.width) &&
         e.min_y < float(camera.height);
}

Rgb MeanColor(const float* dc) {
  const float constant = BasisConstants(Basis::kSh)[0];  // equal for every basis
  Rgb rgb;
  for (size_t k = 0; k < 3; ++k)
    rgb[k] = uint8_t(255 * std::clamp(0.5f + constant * dc[k], 0.0f, 1.0f) + 0.5f);
  return rgb;
}

// Returns false if there is nothing to draw.
bool PlaceEllipsoid(const WorldGaussians& g, size_t i, const Camera& camera, Ellipsoid& e) {
  const float *p = g.position + 3 * i, *q = g.rotation + 4 * i, *s = g.scale_log + 3 * i;
  if (!(g.opacity_logit[i] >= kFaintestLogit)) return false;
  Mat3<float> cam_from_world;
  std::copy(camera.rotation.begin(), camera.rotation.end(), cam_from_world.m);
  const Vec3<float> scale{std::exp(s[0]), std::exp(s[1]), std::exp(s[2])};
  const Mat3<float> turn =
      cam_from_world * math::RotationOf(math::Normalize(math::Quat<float>{q[0], q[1], q[2], q[3]}));
  const Vec3<float> c =
      cam_from_world * Vec3<float>{p[0], p[1], p[2]} +
      Vec3<float>{camera.translation[0], camera.translation[1], camera.translation[2]};
  if (!BoxOf(math::ScaleColumns(turn, scale), c, camera, e)) return false;
  e.sphere_from_cam =
      math::Transpose(math::ScaleColumns(turn, Vec3<float>{1 / scale.x, 1 / scale.y, 1 / scale.z}));
  e.center = e.sphere_from_cam * c;
  e.color = MeanColor(g.color_dc + 3 * i);
  return std::isfinite(math::Dot(e.center, e.center));
}

// The ray d z through a sample meets the unit sphere around m where |d z - m| = 1. The discriminant
// is computed from d x m, as (d m)^2 - d^2 (m^2 - 1) suffers from cancellation if m is far away.
void FillRow(const Ellipsoid& e, int y, const Camera& camera, SurfaceBuffer& buffer) {
  const int begin = std::max(0, int(std::floor(e.min_x)));
  const int end = std::min(buffer.width, int(std::ceil(e.max_x)));
  const float* depth = &buffer.depth[size_t(y) * size_t(buffer.width)];
  const float slope_y = (float(y) + 0.5f - camera.cy) / camera.fy, per_x = 1 / camera.fx;
  const Vec3<float> row = e.sphere_from_cam * Vec3<float>{0, slope_y, 1};
  const Vec3<float> right = e.sphere_from_cam * Vec3<float>{1, 0, 0};
  for (int x = begin; x < end; ++x) {
    if (depth[x] <= e.nearest) continue;
    const Vec3<float> d = row + right * ((float(x) + 0.5f - camera.cx) * per_x);
    const Vec3<float> miss = math::Cross(d, e.center);
    const float a = math::Dot(d, d), square = a - math::Dot(miss, miss);
    if (!(square >= 0)) continue;
    const float z = (math::Dot(d, e.center) - std::sqrt(square)) / a;
    if (!(z < depth[x])) continue;
    const Vec3<float> n =
        math::Normalize(math::TransposeTimes(e.sphere_from_cam, d * z - e.center));
    buffer.Put(x, y, z, Lit(e.color, {n.x, n.y, n.z}));
  }
}

}  // namespace

void DrawEllipsoids(const WorldGaussians& gaussians, const Camera& camera, SurfaceBuffer& buffer) {
  const Camera samples = SampleCamera(camera);
  std::vector<Ellipsoid> all(gaussians.count), drawn;
  std::vector<uint8_t> seen(gaussians.count);
  tbb::parallel_for(size_t(0), gaussians.count, [&](size_t i) {
    seen[i] = PlaceEllipsoid(gaussians, i, samples, all[i]);
  });
  for (size_t i = 0; i < all.size(); ++i)
    if (seen[i]) drawn.push_back(all[i]);
  // Front to back, so that most hidden samples end at the depth test.
  std::stable_sort(drawn.begin(), drawn.end(), [](const Ellipsoid& a, const Ellipsoid& b) {
    return a.nearest < b.nearest;
  });
  ForBands(buffer, [&](int first, int end) {
    for (const Ellipsoid& e : drawn) {
      const int from = std::max(first, int(std::floor(std::max(e.min_y, 0.0f))));
      const int to = std::min(end, int(std::ceil(std::min(e.max_y, float(buffer.height)))));
      for (int y = from; y < to; ++y) FillRow(e, y, samples, buffer);
    }
  });
}

}  // namespace cosplat::viewer
