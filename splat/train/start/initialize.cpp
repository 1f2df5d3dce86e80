#include "splat/train/start/initialize.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <string>

#include "splat/base/error.h"
#include "splat/basis_constants.h"
#include "splat/math/scalar.h"

namespace cosplat {
namespace {

constexpr float kInitialOpacity = 0.1f;     // 3DGS
constexpr float kMinDistance2 = 1e-7f;      // 3DGS: coincident points
constexpr float kSyntheticHalfSize = 1.3f;  // 3DGS: half the cube of Synthetic-NeRF scenes
constexpr float kSphere = 1.01f;            // ratio of distances that are alike

// nanoflann adaptor for [P, 3] floats.
struct PointCloud {
  const std::vector<float>& points;
  size_t kdtree_get_point_count() const { return points.size() / 3; }
  float kdtree_get_pt(size_t i, size_t k) const { return points[3 * i + k]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree = nanoflann::
    KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointCloud>, PointCloud, 3>;

// 1 for distances in the unit of Synthetic-NeRF scenes, whose cameras are 4 from their middle.
float UnitOf(float distance) {
  constexpr float kMax = 100;
  if (distance >= 1 && distance < kMax) return 1;
  return distance > 0 ? std::pow(10.0f, std::floor(std::log10(distance))) : 1;
}

}  // namespace

Gaussians InitializeFromPoints(const std::vector<float>& points,
                               const std::vector<uint8_t>& colors,
                               int degree,
                               Basis basis,
                               float unit) {
  const size_t n = points.size() / 3;
  if (n == 0) throw Error("points", "there are no points to start from");
  for (size_t i = 0; i < points.size(); ++i)
    if (!std::isfinite(points[i]))
      throw Error("points[" + std::to_string(i / 3) + "]", "is not finite");
  Gaussians g;
  g.degree = degree;
  g.basis = basis;
  g.Resize(n);
  const PointCloud cloud{points};
  const Tree tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  tbb::parallel_for(size_t(0), n, [&](size_t i) {
    std::array<uint32_t, 4> index{};
    std::array<float, 4> distance2{};
    const size_t found = tree.knnSearch(&points[3 * i], 4, index.data(), distance2.data());
    float sum = 0;
    for (size_t k = 1; k < found; ++k) sum += distance2[k];
    const float mean = found > 1 ? sum / float(found - 1) : 1.0f;
    const float scale_log = 0.5f * std::log(std::max(mean, unit * unit * kMinDistance2));
    for (int k = 0; k < 3; ++k) {
      g.at(kPosition, i)[k] = points[3 * i + k];
      g.at(kScaleLog, i)[k] = scale_log;
      g.at(kColorDc, i)[k] = (colors[3 * i + k] / 255.0f - 0.5f) / BasisConstants(basis)[0];
    }
    g.at(kRotation, i)[0] = 1;
    g.at(kOpacityLogit, i)[0] = math::Logit(kInitialOpacity);
  });
  return g;
}

void LimitPoints(size_t max, std::vector<float>& points, std::vector<uint8_t>& colors) {
  const size_t n = points.size() / 3;
  if (n <= max) return;
  for (size_t i = 0; i < max; ++i) {
    const size_t from = size_t(uint64_t(i) * n / max);
    for (size_t k = 0; k < 3; ++k) {
      points[3 * i + k] = points[3 * from + k];
      colors[3 * i + k] = colors[3 * from + k];
    }
  }
  points.resize(3 * max);
  colors.resize(3 * max);
}

std::array<float, 3> FocusPoint(const std::vector<Camera>& cameras) {
  double a[3][4] = {};
  for (const Camera& c : cameras) {
    const auto center = c.Center();
    const float* d = &c.rotation[6];  // the optical axis in the world
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        const double p = (i == k) - double(d[i]) * d[k];
        a[i][k] += p;
        a[i][3] += p * center[k];
      }
  }
  // Parallel axes have no such point: a weak pull towards the origin picks one.
  for (int i = 0; i < 3; ++i) a[i][i] += 1e-6 * (1 + double(cameras.size()));
  for (int i = 0; i < 3; ++i)  // Gauss-Jordan: symmetric positive definite, no pivoting needed
    for (int r = 0; r < 3; ++r) {
      if (r == i) continue;
      const double f = a[r][i] / a[i][i];
      for (int k = i; k < 4; ++k) a[r][k] -= f * a[i][k];
    }
  return {float(a[0][3] / a[0][0]), float(a[1][3] / a[1][1]), float(a[2][3] / a[2][2])};
}

void RandomPoints(const std::vector<Camera>& cameras,
                  size_t count,
                  Rng& rng,
                  std::vector<float>& points,
                  std::vector<uint8_t>& colors) {
  std::array<float, 3> focus = FocusPoint(cameras);
  float nearest = std::numeric_limits<float>::max(), farthest = 0, from_origin = 0;
  for (const Camera& c : cameras) {
    const auto p = c.Center();
    const float distance = std::hypot(p[0] - focus[0], p[1] - focus[1], p[2] - focus[2]);
    nearest = std::min(nearest, distance);
    farthest = std::max(farthest, distance);
  }
  for (const float f : focus) from_origin = std::max(from_origin, std::abs(f));
  const float unit = UnitOf(nearest);
  const bool around_origin = from_origin < 0.5f * unit;
  const bool synthetic =
      nearest > kSyntheticHalfSize * unit && (around_origin || farthest < kSphere * nearest);
  const float half = synthetic ? kSyntheticHalfSize * unit
                               : std::max(nearest * 0.5f, 1e-3f * std::min(unit, 1.0f));
  if (synthetic && around_origin) focus = {0, 0, 0};
  for (size_t i = 0; i < 3 * count; ++i) {
    points.push_back(focus[i % 3] + half * (2 * rng.Uniform() - 1));
    colors.push_back(uint8_t(rng.Below(256)));
  }
}

}  // namespace cosplat
