#include "splat/train/blocks/blocks.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "splat/base/error.h"
#include "splat/base/median.h"

namespace cosplat {
namespace {

using Point = std::array<double, 3>;

float HeightOver(const BlockPlane& plane, const float* p) {
  return plane.normal[0] * p[0] + plane.normal[1] * p[1] + plane.normal[2] * p[2] - plane.offset;
}
size_t SideOf(const BlockPlane& plane, const float* p) { return !(HeightOver(plane, p) < 0); }

double Dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The eigenvector of the largest eigenvalue of a symmetric matrix, by power iteration; any of
// them, always the same, where several eigenvalues are the largest.
Point LargestEigenvector(const std::array<Point, 3>& m) {
  constexpr int kIterations = 200;
  size_t widest = 0;
  for (size_t k = 1; k < 3; ++k)
    if (m[k][k] > m[widest][widest]) widest = k;
  Point v{};
  v[widest] = 1;
  for (int i = 0; i < kIterations; ++i) {
    const Point next{Dot(m[0], v), Dot(m[1], v), Dot(m[2], v)};
    const double length = std::sqrt(Dot(next, next));
    if (!(length > 0)) break;  // all points are one
    for (size_t k = 0; k < 3; ++k) v[k] = next[k] / length;
  }
  return v;
}

class Splitter {
 public:
  Splitter(View<const float> points, SceneBlocks& blocks) : points_(points), blocks_(blocks) {}

  // Returns what stands for these points in BlockPlane::side.
  int32_t Split(std::vector<uint32_t> of, size_t blocks) {
    if (blocks == 1) return ~int32_t(leaves_++);
    const size_t index = blocks_.planes.size();
    blocks_.planes.emplace_back();
    BlockPlane plane = PlaneThrough(of, blocks);
    std::vector<uint32_t> sides[2];
    for (const uint32_t i : of) sides[SideOf(plane, Floats(i))].push_back(i);
    const size_t of_side[2] = {blocks / 2, blocks - blocks / 2};
    for (int side = 0; side < 2; ++side) {
      if (sides[side].size() < of_side[side])
        throw Error("--blocks " + std::to_string(blocks_.planes.size() + blocks - 1),
                    "are too many for " + std::to_string(points_.count / 3) +
                        " Gaussians at as many places");
      plane.side[size_t(side)] = Split(std::move(sides[side]), of_side[side]);
    }
    blocks_.planes[index] = plane;
    return int32_t(index);
  }

 private:
  const float* Floats(uint32_t i) const { return points_.data + 3 * size_t(i); }
  Point At(uint32_t i) const {
    const float* p = Floats(i);
    return {double(p[0]), double(p[1]), double(p[2])};
  }

  Point MedianOf(const std::vector<uint32_t>& of) const {
    Point median{};
    std::vector<double> values(of.size());
    for (size_t k = 0; k < 3; ++k) {
      for (size_t i = 0; i < of.size(); ++i) values[i] = At(of[i])[k];
      median[k] = Median(values);
    }
    return median;
  }

  Point PrincipalDirection(const std::vector<uint32_t>& of) const {
    const Point median = MedianOf(of);
    std::vector<double> distances(of.size());
    for (size_t i = 0; i < of.size(); ++i) distances[i] = std::sqrt(Distance2(At(of[i]), median));
    std::vector<double> sorted = distances;
    const double limit = Median(sorted);
    std::array<Point, 3> covariance{};
    for (size_t i = 0; i < of.size(); ++i) {
      const double share = distances[i] > limit ? limit / distances[i] : 1;
      const Point p = At(of[i]);
      for (size_t r = 0; r < 3; ++r)
        for (size_t c = 0; c < 3; ++c)
          covariance[r][c] += share * share * (p[r] - median[r]) * (p[c] - median[c]);
    }
    return LargestEigenvector(covariance);
  }
  static double Distance2(const Point& a, const Point& b) {
    const Point d{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return Dot(d, d);
  }

  // With as large a share of the points below as of the blocks.
  BlockPlane PlaneThrough(const std::vector<uint32_t>& of, size_t blocks) const {
    BlockPlane plane;
    const Point normal = PrincipalDirection(of);
    for (size_t k = 0; k < 3; ++k) plane.normal[k] = float(normal[k]);
    std::vector<float> heights(of.size());
    for (size_t i = 0; i < of.size(); ++i) heights[i] = HeightOver(plane, Floats(of[i]));
    const auto first_above = heights.begin() + std::ptrdiff_t(of.size() * (blocks / 2) / blocks);
    std::nth_element(heights.begin(), first_above, heights.end());
    plane.offset = *first_above;
    return plane;
  }

  View<const float> points_;
  SceneBlocks& blocks_;
  size_t leaves_ = 0;
};

}  // namespace

size_t SceneBlocks::BlockOf(const float* p) const {
  if (planes.empty()) return 0;
  for (int32_t at = 0;;) {
    const BlockPlane& plane = planes[size_t(at)];
    at = plane.side[SideOf(plane, p)];
    if (at < 0) return size_t(~at);
  }
}

std::vector<uint32_t> SceneBlocks::FrontToBack(const std::array<float, 3>& eye) const {
  std::vector<uint32_t> order;
  std::vector<int32_t> left{planes.empty() ? ~0 : 0};  // the next one is at the back
  while (!left.empty()) {
    const int32_t at = left.back();
    left.pop_back();
    if (at < 0) {
      order.push_back(uint32_t(~at));
      continue;
    }
    const BlockPlane& plane = planes[size_t(at)];
    const size_t own = SideOf(plane, eye.data());
    left.push_back(plane.side[1 - own]);
    left.push_back(plane.side[own]);
  }
  return order;
}

SceneBlocks SplitByPlace(View<const float> points, size_t blocks) {
  SceneBlocks split;
  std::vector<uint32_t> all(points.count / 3);
  for (size_t i = 0; i < all.size(); ++i) all[i] = uint32_t(i);
  Splitter(points, split).Split(std::move(all), blocks);
  return split;
}

void Serialize(StateArchive& a, size_t count, SceneBlocks& blocks) {
  a.Array("blocks.planes", blocks.planes, count - 1);
  if (!a.reads()) return;
  for (size_t i = 0; i < blocks.planes.size(); ++i)
    for (const int32_t side : blocks.planes[i].side)
      a.Require(side < 0 ? size_t(~side) < count : size_t(side) > i && size_t(side) < count - 1,
                "blocks.planes",
                "are not a tree");
}

}  // namespace cosplat
