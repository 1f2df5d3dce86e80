#include "flame/mouth.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "flame/added_mesh.h"
#include "flame/topology.h"
#include "flame/vhap_teeth.h"

namespace cosplat {
namespace {

constexpr int kJawJoint = 2;

using Point = std::array<float, 3>;

Point PointOf(const FlameModel& model, int v) {
  const float* p = &model.template_vertices[3 * size_t(v)];
  return {p[0], p[1], p[2]};
}

float JawWeight(const FlameModel& model, int v) {
  return model.skinning_weights[kFlameJoints * size_t(v) + kJawJoint];
}

struct Extent {
  Point min{1e30f, 1e30f, 1e30f}, max{-1e30f, -1e30f, -1e30f};
  float Middle(int axis) const { return 0.5f * (min[axis] + max[axis]); }
  float Size(int axis) const { return max[axis] - min[axis]; }
};

Extent ExtentOf(const FlameModel& model, const std::vector<int32_t>& vertices) {
  Extent extent;
  for (const int32_t v : vertices)
    for (int axis = 0; axis < 3; ++axis) {
      extent.min[axis] = std::min(extent.min[axis], PointOf(model, v)[axis]);
      extent.max[axis] = std::max(extent.max[axis], PointOf(model, v)[axis]);
    }
  return extent;
}

// How far the face reaches in front of the rim, where a ray from its middle leaves it.
float DepthBehindFace(const FlameModel& model, const Extent& rim) {
  float front = rim.max[2];
  for (int v = 0; v < model.vertex_count; ++v) {
    const Point p = PointOf(model, v);
    if (std::abs(p[0] - rim.Middle(0)) < 0.25f * rim.Size(0) &&
        std::abs(p[1] - rim.Middle(1)) < 0.5f * rim.Size(1))
      front = std::max(front, p[2]);
  }
  return front - rim.max[2];
}

// The rim of the hole behind the lips, counter-clockwise seen from the front, or empty.
std::vector<int32_t> MouthRim(const FlameModel& model) {
  MeshTopology mesh = BuildTopology(model.name, model.faces, model.vertex_count);
  if (mesh.boundary_loops.size() < 2) return {};
  const auto higher = [&](const std::vector<int32_t>& a, const std::vector<int32_t>& b) {
    return ExtentOf(model, a).Middle(1) < ExtentOf(model, b).Middle(1);
  };
  std::vector<int32_t> rim =
      *std::max_element(mesh.boundary_loops.begin(), mesh.boundary_loops.end(), higher);
  const Extent extent = ExtentOf(model, rim);
  const auto [skull, jaw] = std::minmax_element(rim.begin(), rim.end(), [&](int a, int b) {
    return JawWeight(model, a) < JawWeight(model, b);
  });
  if (JawWeight(model, *skull) > 0.3f || JawWeight(model, *jaw) < 0.7f) return {};
  if (DepthBehindFace(model, extent) > extent.Size(0)) return {};
  float area = 0;
  for (size_t i = 0; i < rim.size(); ++i) {
    const Point a = PointOf(model, rim[i]), b = PointOf(model, rim[(i + 1) % rim.size()]);
    area += a[0] * b[1] - b[0] * a[1];
  }
  if (area < 0) std::reverse(rim.begin(), rim.end());
  return rim;
}

class MouthBuilder {
 public:
  MouthBuilder(const FlameModel& model, std::vector<int32_t> rim)
      : model_(model), rim_(std::move(rim)), extent_(ExtentOf(model, rim_)) {}

  // The lengths below are shares of the rim's width, about 53 mm for an adult.
  void Build() {
    // Middle heights split the rim into the part of the skull and that of the jaw, both from the
    // left of the image to the right.
    std::vector<int32_t> upper, lower;
    for (const int32_t v : rim_)
      (PointOf(model_, v)[1] > extent_.Middle(1) ? upper : lower).push_back(v);
    const auto by_x = [&](int a, int b) { return PointOf(model_, a)[0] < PointOf(model_, b)[0]; };
    std::sort(upper.begin(), upper.end(), by_x);
    std::sort(lower.begin(), lower.end(), by_x);
    // The upper incisors reach below the line of the lips and cover the lower ones.
    parts_.upper_teeth = AddTeeth(upper, extent_.Middle(1) - 0.03f * Width(), 0.02f, 0, false);
    parts_.lower_teeth = AddTeeth(lower, extent_.Middle(1) - 0.01f * Width(), -0.03f, 1, true);
    parts_.bowl = AddBowl();
  }

  const MouthParts& parts() const { return parts_; }
  const std::vector<AddedVertex>& vertices() const { return vertices_; }
  const std::vector<std::array<int32_t, 3>>& faces() const { return faces_; }

 private:
  float Width() const { return extent_.Size(0); }

  // A sheet from the rim's `arc` to the height of the teeth's edges; returns how many vertices.
  int AddTeeth(const std::vector<int32_t>& arc, float edge, float forward, float jaw, bool up) {
    constexpr int kRows = 4;
    const int columns = int(arc.size());
    const int first = int(vertices_.size());
    for (int r = 0; r <= kRows; ++r)
      for (int c = 0; c < columns; ++c) {
        AddedVertex v;
        v.moves_with = arc[size_t(c)];
        v.jaw = jaw;
        // The average of the rim's shape directions about this column: the arch of the teeth does
        // not have the lips' detail.
        constexpr int kReach = 3;
        for (int k = std::max(0, c - kReach); k <= std::min(columns - 1, c + kReach); ++k)
          v.shape_of.push_back({arc[size_t(k)], 1.0f});
        for (auto& [of, weight] : v.shape_of) weight /= float(v.shape_of.size());
        const Point root = PointOf(model_, v.moves_with);
        const float t = float(r) / kRows;
        v.place = {root[0] * (1 - 0.06f * t),
                   root[1] + t * (edge - root[1]),
                   root[2] + Width() * (forward + 0.04f * std::sin(3.14159265f * t))};
        vertices_.push_back(v);
      }
    AddStrips(first, columns, kRows, !up, false);
    return int(vertices_.size()) - first;
  }

  // Rings that grow narrower towards the throat; returns how many vertices.
  int AddBowl() {
    constexpr int kRings = 4;
    const int n = int(rim_.size()), first = int(vertices_.size());
    for (int r = 0; r <= kRings; ++r)
      for (const int32_t of : rim_) {
        const Point p = PointOf(model_, of);
        const float t = float(r) / kRings, narrow = 1 - 0.8f * t * t;
        AddedVertex v;
        v.moves_with = of;
        v.shape_of = {{of, 1.0f}};
        v.motion = 1 - t;
        v.jaw = JawWeight(model_, of);
        for (int axis = 0; axis < 2; ++axis)
          v.place[size_t(axis)] =
              extent_.Middle(axis) + narrow * (p[size_t(axis)] - extent_.Middle(axis));
        v.place[2] = p[2] - Width() * (0.03f + 0.55f * t);
        vertices_.push_back(v);
      }
    AddStrips(first, n, kRings, false, true);
    return int(vertices_.size()) - first;
  }

  // Faces between successive rows of vertices.
  void AddStrips(int first, int columns, int rows, bool turned, bool closed) {
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < (closed ? columns : columns - 1); ++c) {
        const int next = (c + 1) % columns;
        const int32_t a = first + r * columns + c, b = first + r * columns + next;
        const int32_t d = a + columns, e = b + columns;
        if (turned) {
          faces_.push_back({a, d, e});
          faces_.push_back({a, e, b});
        } else {
          faces_.push_back({a, e, d});
          faces_.push_back({a, b, e});
        }
      }
  }

  const FlameModel& model_;
  std::vector<int32_t> rim_;
  Extent extent_;
  MouthParts parts_;
  std::vector<AddedVertex> vertices_;
  std::vector<std::array<int32_t, 3>> faces_;
};

}  // namespace

FlameModel WithMouth(FlameModel model) {
  if (model.mouth.count() > 0) return model;
  const std::vector<int32_t> rim = MouthRim(model);
  if (rim.empty()) return model;
  MouthBuilder mouth(model, rim);
  mouth.Build();
  AddToMesh(mouth.vertices(), mouth.faces(), model);
  model.mouth = mouth.parts();
  return model;
}

std::vector<float> StaticOffsetFor(const FlameModel& model, std::vector<float> offset) {
  const size_t own = 3 * size_t(model.own_vertex_count());
  const bool with_teeth = offset.size() == own + 3 * size_t(kVhapTeeth);
  if (offset.size() != own && !with_teeth) return offset;
  std::array<Point, 2> mean{};  // of the lower and of the upper teeth
  for (int i = 0; with_teeth && i < kVhapTeeth; ++i)
    for (size_t axis = 0; axis < 3; ++axis)
      mean[kVhapRowIsUpper[size_t(i / kVhapRow)]][axis] +=
          offset[own + 3 * size_t(i) + axis] / float(kVhapTeeth / 2);
  offset.resize(own);
  const auto append = [&](int count, const Point& moved) {
    for (int i = 0; i < count; ++i) offset.insert(offset.end(), moved.begin(), moved.end());
  };
  append(model.mouth.upper_teeth, mean[true]);
  append(model.mouth.lower_teeth, mean[false]);
  append(model.mouth.bowl, {});
  return offset;
}

}  // namespace cosplat
