#include "flame/model.h"

#include <algorithm>
#include <cmath>

#include "flame/blendshape_names.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// FLAME's own weights sum to 1 within 2e-7; hand-made and requantised files, within a thousandth.
constexpr double kWeightSumTolerance = 1e-3;

void CheckFinite(const FlameModel& model,
                 const char* array,
                 const std::vector<float>& values,
                 size_t expected) {
  if (values.size() != expected)
    throw Error(model.name, array, Format("has {} numbers, expected {}", values.size(), expected));
  for (size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw Error(model.name, array, Format("number {} is not finite ({})", i, values[i]));
}

void CheckFaces(const FlameModel& model) {
  if (model.faces.empty()) throw Error(model.name, "faces", "has no faces");
  for (size_t f = 0; f < model.faces.size(); ++f)
    for (int32_t v : model.faces[f])
      if (v < 0 || v >= model.vertex_count)
        throw Error(model.name,
                    "faces",
                    "face " + std::to_string(f) + " refers to vertex " + std::to_string(v) +
                        ", but there are only " + std::to_string(model.vertex_count));
}

void CheckRowsSumToOne(const FlameModel& model,
                       const char* array,
                       const std::vector<float>& values,
                       size_t columns) {
  for (size_t r = 0; r * columns < values.size(); ++r) {
    double sum = 0;
    for (size_t c = 0; c < columns; ++c) sum += values[r * columns + c];
    if (std::abs(sum - 1) > kWeightSumTolerance)
      throw Error(model.name, array, Format("row {} sums to {}, expected 1", r, sum));
  }
}

void CheckParents(const FlameModel& model) {
  for (int j = 0; j < kFlameJoints; ++j) {
    const int p = model.parents[j];
    if (j == 0 ? p != -1 : (p < 0 || p >= j))
      throw Error(model.name,
                  "parents",
                  "joint " + std::to_string(j) + " has parent " + std::to_string(p) +
                      ", expected an earlier joint (-1 for the root)");
  }
}

void CheckLandmarks(const FlameModel& model) {
  for (size_t i = 0; i < model.landmarks.size(); ++i) {
    const EmbeddedLandmark& point = model.landmarks[i];
    const auto bad = [&](const std::string& what) {
      return Error(model.name, "landmarks[" + std::to_string(i) + "]", what);
    };
    double sum = 0;
    for (size_t k = 0; k < 3; ++k) {
      if (point.vertices[k] < 0 || point.vertices[k] >= model.vertex_count)
        throw bad("is on vertex " + std::to_string(point.vertices[k]));
      sum += point.barycentric[k];
    }
    if (!(std::abs(sum - 1) < 1e-3)) throw bad("barycentric coordinates do not sum to 1");
    if (!(point.looseness > 0 && point.looseness < 1e6))
      throw bad("looseness is " + std::to_string(point.looseness));
  }
}

void CheckNames(const FlameModel& model) {
  const std::vector<std::string>& names = model.expression_names;
  if (names.empty()) return;
  CheckFinite(model, "expression_scores", model.expression_scores, size_t(model.expression_count));
  if (names.size() != size_t(model.expression_count))
    throw Error(model.name,
                "expression_names",
                Format("has {} names for {} directions", names.size(), model.expression_count));
  for (size_t e = 0; e < names.size(); ++e) {
    if (names[e].empty()) continue;
    if (FindArkitBlendshape(names[e]) < 0 || std::count(names.begin(), names.end(), names[e]) > 1)
      throw Error(model.name,
                  Format("expression_names[{}]", e),
                  "is '" + names[e] + "', expected each of ARKit's names once");
    if (!(model.expression_scores[e] > 0 && model.expression_scores[e] < 100))
      throw Error(model.name,
                  Format("expression_scores[{}]", e),
                  Format("is {}, expected 0 to 100", model.expression_scores[e]));
  }
}

}  // namespace

void Validate(const FlameModel& model) {
  if (model.vertex_count <= 0)
    throw Error(model.name, "vertex_count", std::to_string(model.vertex_count) + " vertices");
  if (model.shape_count < 0 || model.expression_count < 0)
    throw Error(model.name, "shape_count, expression_count", "negative");
  const size_t v = model.vertex_count;
  CheckFinite(model, "template_vertices", model.template_vertices, 3 * v);
  CheckFinite(model, "shape_directions", model.shape_directions, 3 * v * model.shape_count);
  CheckFinite(
      model, "expression_directions", model.expression_directions, 3 * v * model.expression_count);
  CheckFinite(model, "pose_directions", model.pose_directions, 3 * v * kFlamePoseFeatures);
  CheckFinite(model, "joint_regressor", model.joint_regressor, v * kFlameJoints);
  CheckFinite(model, "skinning_weights", model.skinning_weights, v * kFlameJoints);
  CheckFaces(model);
  CheckParents(model);
  CheckLandmarks(model);
  CheckNames(model);
  CheckRowsSumToOne(model, "skinning_weights", model.skinning_weights, kFlameJoints);
  CheckRowsSumToOne(model, "joint_regressor", model.joint_regressor, v);
}

}  // namespace cosplat
