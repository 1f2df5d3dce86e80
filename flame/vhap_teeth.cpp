#include "flame/vhap_teeth.h"

#include <cmath>
#include <string>
#include <vector>

#include "flame/added_mesh.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr int kFlameFaces = 9976;

// FLAME's vertices on the outer rim of the upper and of the lower lip.
using LipRing = std::array<int32_t, kVhapRow>;
constexpr LipRing kUpperLip = {
    1713, 1715, 1716, 1735, 1696, 1694, 1657, 3543, 2774, 2811, 2813, 2850, 2833, 2832, 2830};
constexpr LipRing kLowerLip = {
    1576, 1577, 1773, 1774, 1795, 1802, 1865, 3503, 2948, 2905, 2898, 2881, 2880, 2713, 2712};

// How far a row is above and in front of the middle between the lips, in units of their distance.
struct RowPlace {
  float up, forward;
};
constexpr std::array<RowPlace, 8> kRowPlaces = {{{2.1f, -1.5f},     // upper roots
                                                 {-2.1f, -1.9f},    // lower roots
                                                 {0.1f, -1.5f},     // upper edges
                                                 {-0.1f, -1.9f},    // lower edges
                                                 {2.1f, -2.5f},     // upper roots, back
                                                 {0.1f, -2.5f},     // upper edges, back
                                                 {-2.1f, -2.9f},    // lower roots, back
                                                 {-0.1f, -2.9f}}};  // lower edges, back

// Two triangles per column between the rows' vertices, counted 0, 1 (first row) and 2, 3 (second
// row). The order of the corners matters, because Gaussians are placed by the face's first edge.
using Cell = std::array<std::array<int, 3>, 2>;
constexpr Cell kTurnedAlong03 = {{{0, 3, 2}, {0, 1, 3}}}, kTurnedAlong12 = {{{0, 1, 2}, {1, 3, 2}}};
constexpr Cell kAlong03 = {{{0, 2, 3}, {0, 3, 1}}}, kAlong12 = {{{0, 2, 1}, {1, 2, 3}}};

// A strip of faces; its diagonals are mirrored about the middle column.
struct Strip {
  int first_row, second_row;
  Cell left, right;  // the columns of the subject's left, and of its right
};
constexpr std::array<Strip, 6> kStrips = {{{0, 2, kTurnedAlong03, kTurnedAlong12},    // upper front
                                           {4, 5, kAlong03, kAlong12},                // back
                                           {5, 2, kAlong12, kAlong03},                // and edge
                                           {3, 1, kTurnedAlong12, kTurnedAlong03},    // lower front
                                           {6, 7, kTurnedAlong03, kTurnedAlong12},    // back
                                           {7, 3, kTurnedAlong12, kTurnedAlong03}}};  // and edge

const float* PlaceOf(const FlameModel& model, int32_t v) {
  return &model.template_vertices[3 * size_t(v)];
}

float LipDistance(const FlameModel& model) {
  float sum = 0;
  for (size_t i = 0; i < kVhapRow; ++i) {
    const float *a = PlaceOf(model, kUpperLip[i]), *b = PlaceOf(model, kLowerLip[i]);
    sum += std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / kVhapRow;
  }
  return sum;
}

// The middle between the lips, column by column, at the columns' mean height.
std::array<std::array<float, 3>, kVhapRow> MiddlesOf(const FlameModel& model) {
  std::array<std::array<float, 3>, kVhapRow> middles{};
  float height = 0;
  for (size_t i = 0; i < kVhapRow; ++i)
    for (size_t k = 0; k < 3; ++k) {
      middles[i][k] = (PlaceOf(model, kUpperLip[i])[k] + PlaceOf(model, kLowerLip[i])[k]) / 2;
      if (k == 1) height += middles[i][1] / kVhapRow;
    }
  for (auto& middle : middles) middle[1] = height;
  return middles;
}

std::vector<AddedVertex> VerticesOf(const FlameModel& model) {
  const float unit = LipDistance(model);
  const auto middles = MiddlesOf(model);
  std::vector<AddedVertex> vertices;
  for (size_t row = 0; row < kRowPlaces.size(); ++row)
    for (size_t i = 0; i < kVhapRow; ++i) {
      AddedVertex v;
      v.place = {middles[i][0],
                 middles[i][1] + unit * kRowPlaces[row].up,
                 middles[i][2] + unit * kRowPlaces[row].forward};
      v.shape_of = {{kUpperLip[i], 0.5f}, {kLowerLip[i], 0.5f}};
      v.jaw = kVhapRowIsUpper[row] ? 0 : 1;
      vertices.push_back(v);
    }
  return vertices;
}

std::vector<std::array<int32_t, 3>> FacesOf() {
  std::vector<std::array<int32_t, 3>> faces;
  for (const Strip& strip : kStrips)
    for (int c = 0; c + 1 < kVhapRow; ++c) {
      const int first = kVhapRow * strip.first_row + c, second = kVhapRow * strip.second_row + c;
      const std::array<int32_t, 4> corners{first, first + 1, second, second + 1};
      for (const auto& face : c < kVhapRow / 2 ? strip.left : strip.right)
        faces.push_back(
            {corners[size_t(face[0])], corners[size_t(face[1])], corners[size_t(face[2])]});
    }
  return faces;
}

}  // namespace

bool HasFlameTopology(const FlameModel& model) {
  return model.own_vertex_count() == kFlameVertices && model.faces.size() >= kFlameFaces;
}

FlameModel WithVhapTeeth(FlameModel model) {
  if (model.mouth.vhap_teeth > 0) return model;
  if (!HasFlameTopology(model) || model.mouth.count() > 0)
    throw Error(model.name,
                "vertices",
                "there are " + std::to_string(model.vertex_count) +
                    ", but VHAP's teeth are defined for FLAME's 5023");
  AddToMesh(VerticesOf(model), FacesOf(), model);
  model.mouth.vhap_teeth = kVhapTeeth;
  return model;
}

}  // namespace cosplat
