#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "flame/fit/points_on_flame.h"
#include "flame/fit/silhouette.h"

namespace cosplat::internal {
namespace {

// The outline changes with the offset, and is found anew as often.
constexpr int kRounds = 6;
// Metres: beyond it, what the rim shows is not hair on this head.
constexpr double kMaxHair = 0.08;
// Metres behind the eyes' joint, from where on there may be hair.
constexpr double kBehindEyes = 0.01;
// Weights against one point of one frame's outline: of differences along an edge, and of the
// offset.
constexpr double kSmooth = 3, kSmall = 0.03;

std::vector<Eigen::Vector3d> NormalsOf(const FlameModel& model) {
  const auto at = [&](int32_t v) {
    return Eigen::Map<const Eigen::Vector3f>(&model.template_vertices[3 * size_t(v)]);
  };
  std::vector<Eigen::Vector3d> normals(size_t(model.vertex_count), Eigen::Vector3d::Zero());
  for (const auto& [a, b, c] : SkinFaces(model)) {
    const Eigen::Vector3d normal = (at(b) - at(a)).cross(at(c) - at(a)).cast<double>();
    for (int32_t v : {a, b, c}) normals[size_t(v)] += normal;
  }
  for (Eigen::Vector3d& normal : normals) normal.normalize();
  return normals;
}

// Numbers the vertices that may move; -1 for those that stay: the face, and all that joints depend
// on.
std::vector<int> UnknownsOf(const FlameModel& model, const std::vector<bool>& may_have_hair) {
  constexpr size_t kLeftEye = 3;
  const size_t count = size_t(model.vertex_count);
  const auto regresses = [&](size_t joint, size_t v) {
    return model.joint_regressor[joint * count + v];
  };
  double eyes = 0;
  for (size_t v = 0; v < count; ++v)
    eyes += double(regresses(kLeftEye, v)) * model.template_vertices[3 * v + 2];
  std::vector<int> unknown(count, -1);
  int next = 0;
  for (size_t v = 0; v < count; ++v) {
    bool free = may_have_hair[v] && model.template_vertices[3 * v + 2] < eyes - kBehindEyes;
    for (size_t j = 0; j < size_t(kFlameJoints); ++j) free = free && regresses(j, v) == 0;
    if (free) unknown[v] = next++;
  }
  return unknown;
}

using Entries = std::vector<Eigen::Triplet<double>>;

// Adds weight (a h_i + b h_j - value)^2 to the least squares' normal equations.
struct Term {
  std::array<int, 2> unknown;
  std::array<double, 2> factor;
  double value, weight;
};
void Add(const Term& term, Entries& matrix, Eigen::VectorXd& right) {
  for (size_t i = 0; i < 2; ++i) {
    if (term.unknown[i] < 0) continue;
    right[term.unknown[i]] += term.weight * term.factor[i] * term.value;
    for (size_t j = 0; j < 2; ++j)
      if (term.unknown[j] >= 0)
        matrix.emplace_back(
            term.unknown[i], term.unknown[j], term.weight * term.factor[i] * term.factor[j]);
  }
}

}  // namespace

std::vector<float> FitHairOffset(const FlameModel& model,
                                 const std::vector<double>& shape,
                                 double log_focal,
                                 const std::vector<std::vector<double>>& frames,
                                 const std::vector<size_t>& picked,
                                 const std::vector<std::optional<FrameView>>& views,
                                 const std::vector<FrameFields>& fields) {
  const int shapes = int(shape.size());
  const int expressions = int(frames[picked.at(0)].size()) - kFitExpression;
  const std::vector<Eigen::Vector3d> normals = NormalsOf(model);
  FlameModel with_hair = model;
  std::vector<int> unknown;
  Eigen::VectorXd hair;
  for (int round = 0; round < kRounds; ++round) {
    const Silhouette silhouette(with_hair, shapes, expressions);
    if (round == 0) {
      unknown = UnknownsOf(model, silhouette.may_have_hair());
      hair.setZero(1 + *std::max_element(unknown.begin(), unknown.end()));
      if (hair.size() == 0) return {};
    }
    std::vector<std::vector<OutlinePoint>> outlines(picked.size());
    tbb::parallel_for(size_t(0), picked.size(), [&](size_t i) {
      const size_t f = picked[i];
      if (fields[f].rim)
        outlines[i] = silhouette.Outline(
            shape.data(), log_focal, frames[f].data(), *fields[f].rim, *views[f]);
    });
    Entries matrix;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(hair.size());
    size_t seen = 0;
    for (const auto& outline : outlines)
      for (const OutlinePoint& point : outline) {
        const int a = unknown[size_t(point.vertices[0])], b = unknown[size_t(point.vertices[1])];
        const double t = point.toward_second;
        const double now = (a < 0 ? 0 : (1 - t) * hair[a]) + (b < 0 ? 0 : t * hair[b]);
        const double should = now - point.distance / point.pixels_per_metre;
        if ((a < 0 && b < 0) || should > kMaxHair) continue;
        Add({{a, b}, {1 - t, t}, std::max(should, 0.0), 1}, matrix, right);
        ++seen;
      }
    if (seen == 0) return {};
    for (const auto& face : SkinFaces(model))
      for (size_t k = 0; k < 3; ++k)
        Add({{unknown[size_t(face[k])], unknown[size_t(face[(k + 1) % 3])]}, {1, -1}, 0, kSmooth},
            matrix,
            right);
    for (int k = 0; k < int(hair.size()); ++k) Add({{k, -1}, {1, 0}, 0, kSmall}, matrix, right);
    Eigen::SparseMatrix<double> normal_matrix(hair.size(), hair.size());
    normal_matrix.setFromTriplets(matrix.begin(), matrix.end());
    hair = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal_matrix).solve(right);
    hair = hair.cwiseMax(0.0).cwiseMin(kMaxHair);
    for (size_t v = 0; v < unknown.size(); ++v)
      for (size_t k = 0; unknown[v] >= 0 && k < 3; ++k)
        with_hair.template_vertices[3 * v + k] =
            float(model.template_vertices[3 * v + k] + hair[unknown[v]] * normals[v][long(k)]);
  }
  std::vector<float> offset(model.template_vertices.size());
  for (size_t i = 0; i < offset.size(); ++i)
    offset[i] = with_hair.template_vertices[i] - model.template_vertices[i];
  return offset;
}

}  // namespace cosplat::internal
