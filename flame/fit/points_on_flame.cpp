#include "flame/fit/points_on_flame.h"

#include <Eigen/Core>
#include <algorithm>
#include <map>

#include "flame/math/rodrigues.h"
#include "flame/math/skinning.h"

namespace cosplat {
namespace {

using math::Mat3;
using math::Vec3;

void AddScaled(double a, const double* x, size_t count, double* sum) {
  for (size_t i = 0; i < count; ++i) sum[i] += a * x[i];
}

double DotOf(const double* a, const double* b, size_t count) {
  using Row = Eigen::Map<const Eigen::VectorXd>;
  return Row(a, Eigen::Index(count)).dot(Row(b, Eigen::Index(count)));
}

// The expression directions that the fit's coefficients stand for.
std::vector<int> ExpressionOrder(const FlameModel& model, int count) {
  std::vector<int> order;
  const int lids = model.has_eyelids ? 2 : 0;
  for (int k = 0; k < count - lids; ++k) order.push_back(k);
  for (int k = 0; k < lids; ++k) order.push_back(model.expression_count - lids + k);
  return order;
}

}  // namespace

void SetFromRow(const std::vector<double>& row, FlameParams& params) {
  for (size_t i = 0; i < 3; ++i) params.translation[i] = float(row[kFitTranslation + i]);
  for (size_t j = 0; j < kFlameJoints; ++j)
    for (size_t i = 0; i < 3; ++i) params.pose[j][i] = float(row[kFitPose + 3 * j + i]);
  params.expression.assign(row.begin() + kFitExpression, row.end());
}

PointsOnFlame::PointsOnFlame(const FlameModel& model,
                             const LandmarkEmbedding& embedding,
                             int shape_count,
                             int expression_count)
    : shape_count_(shape_count), expression_count_(expression_count), parents_(model.parents) {
  std::map<int, int> kept;
  for (const EmbeddedLandmark& point : embedding) {
    std::array<Corner, 3> corners;
    for (int k = 0; k < 3; ++k) {
      const int next = int(kept.size());
      corners[k] = {kept.emplace(point.vertices[k], next).first->second, point.barycentric[k]};
    }
    corners_.push_back(corners);
  }
  const std::vector<int> expression = ExpressionOrder(model, expression_count);
  const size_t rows = 3 * size_t(model.vertex_count);
  // The directions' values at one coordinate, in the order of columns().
  const auto shape_and_expression = [&](size_t row, double* out) {
    for (int k = 0; k < shape_count; ++k) *out++ = model.shape_directions[k * rows + row];
    for (int k : expression) *out++ = model.expression_directions[k * rows + row];
  };
  template_.resize(3 * kept.size());
  directions_.resize(template_.size() * columns());
  weights_.resize(kFlameJoints * kept.size());
  for (const auto& [vertex, place] : kept) {
    std::copy_n(&model.skinning_weights[kFlameJoints * size_t(vertex)],
                kFlameJoints,
                &weights_[kFlameJoints * size_t(place)]);
    for (size_t i = 0; i < 3; ++i) {
      const size_t row = 3 * size_t(vertex) + i, to = 3 * size_t(place) + i;
      template_[to] = model.template_vertices[row];
      double* const out = &directions_[to * columns()];
      shape_and_expression(row, out);
      for (size_t k = 0; k < kFlamePoseFeatures; ++k)
        out[columns() - kFlamePoseFeatures + k] = model.pose_directions[k * rows + row];
    }
  }
  const size_t blends = size_t(shape_count + expression_count);
  joint_directions_.resize(3 * kFlameJoints * blends);
  std::vector<double> at(blends);
  for (size_t v = 0; v < size_t(model.vertex_count); ++v)
    for (size_t j = 0; j < kFlameJoints; ++j) {
      const double w = model.joint_regressor[j * size_t(model.vertex_count) + v];
      if (w == 0) continue;
      for (size_t i = 0; i < 3; ++i) {
        rest_joints_[3 * j + i] += w * model.template_vertices[3 * v + i];
        shape_and_expression(3 * v + i, at.data());
        AddScaled(w, at.data(), blends, joint_directions_.data() + (3 * j + i) * blends);
      }
    }
}

PointsOnFlame PointsOnFlame::Part(const std::vector<int>& points, const double* shape) const {
  PointsOnFlame part;
  part.expression_count_ = expression_count_;
  part.parents_ = parents_;
  const size_t shapes = size_t(shape_count_), rest = columns() - shapes;
  std::vector<int> places(template_.size() / 3, -1);  // of the vertices, in the part
  for (const int point : points) {
    std::array<Corner, 3> corners = corners_[size_t(point)];
    for (Corner& corner : corners) {
      const size_t vertex = size_t(corner.vertex);
      if (places[vertex] < 0) {
        places[vertex] = int(part.template_.size() / 3);
        const double* const weights = &weights_[kFlameJoints * vertex];
        part.weights_.insert(part.weights_.end(), weights, weights + kFlameJoints);
        for (size_t row = 3 * vertex; row < 3 * vertex + 3; ++row) {
          const double* const directions = &directions_[row * columns()];
          part.template_.push_back(template_[row] + DotOf(directions, shape, shapes));
          part.directions_.insert(
              part.directions_.end(), directions + shapes, directions + shapes + rest);
        }
      }
      corner.vertex = places[vertex];
    }
    part.corners_.push_back(corners);
  }
  const size_t blends = size_t(shape_count_ + expression_count_);
  for (size_t row = 0; row < rest_joints_.size(); ++row) {
    const double* const directions = &joint_directions_[row * blends];
    part.rest_joints_[row] = rest_joints_[row] + DotOf(directions, shape, shapes);
    part.joint_directions_.insert(
        part.joint_directions_.end(), directions + shapes, directions + blends);
  }
  return part;
}

void PointsOnFlame::Pose(const double* shape, const double* frame, Tape& tape) const {
  std::vector<double> coefficients(columns());
  const size_t blends = columns() - kFlamePoseFeatures;
  std::copy_n(shape, shape_count_, coefficients.begin());
  std::copy_n(frame + kFitExpression, expression_count_, coefficients.begin() + shape_count_);
  for (size_t j = 0; j < kFlameJoints; ++j) {
    tape.pose[j] = math::ToVec3(frame + kFitPose + 3 * j);
    tape.local[j] = flame_math::Rodrigues(tape.pose[j]);
    for (int i = 0; i < 3; ++i)
      tape.joints[j][i] =
          rest_joints_[3 * j + i] +
          DotOf(joint_directions_.data() + (3 * j + i) * blends, coefficients.data(), blends);
    for (size_t i = 0; j > 0 && i < 9; ++i)
      coefficients[blends + 9 * (j - 1) + i] = tape.local[j].m[i] - (i % 4 == 0 ? 1 : 0);
  }
  tape.transforms = flame_math::PoseJoints(tape.local, tape.joints, parents_);
  tape.unskinned.resize(template_.size());
  for (size_t row = 0; row < template_.size(); ++row)
    tape.unskinned[row] =
        template_[row] + DotOf(&directions_[row * columns()], coefficients.data(), columns());
  tape.points.assign(corners_.size(), {});
  for (size_t p = 0; p < corners_.size(); ++p) {
    for (const auto& [v, weight] : corners_[p]) {
      const double* u = &tape.unskinned[3 * size_t(v)];
      const Vec3<double> posed = flame_math::SkinPoint(
          tape.transforms, &weights_[kFlameJoints * size_t(v)], math::ToVec3(u));
      AddScaled(weight, &posed.x, 3, tape.points[p].data());
    }
    AddScaled(1, frame + kFitTranslation, 3, tape.points[p].data());
  }
}

void PointsOnFlame::Backward(const Tape& tape,
                             int point,
                             const std::array<double, 3>& d_point,
                             double* d_shape,
                             double* d_frame) const {
  const size_t blends = columns() - kFlamePoseFeatures;
  const size_t first = d_shape ? 0 : size_t(shape_count_);
  std::vector<double> d_coefficients(columns());
  flame_math::JointTransforms<double, kFlameJoints> d_transforms{};
  for (const auto& [v, weight] : corners_[size_t(point)]) {
    if (weight == 0) continue;
    const double* u = &tape.unskinned[3 * size_t(v)];
    const Vec3<double> d_unskinned = flame_math::SkinPointVjp(tape.transforms,
                                                              &weights_[kFlameJoints * size_t(v)],
                                                              math::ToVec3(u),
                                                              weight * math::ToVec3(d_point),
                                                              d_transforms);
    for (size_t i = 0; i < 3; ++i)
      AddScaled(d_unskinned[i],
                &directions_[(3 * size_t(v) + i) * columns() + first],
                columns() - first,
                &d_coefficients[first]);
  }
  std::array<Mat3<double>, kFlameJoints> d_local{};
  std::array<Vec3<double>, kFlameJoints> d_joints{};
  flame_math::PoseJointsVjp(
      tape.local, tape.joints, parents_, tape.transforms, d_transforms, d_local, d_joints);
  for (size_t j = 0; j < kFlameJoints; ++j) {
    for (size_t i = 0; j > 0 && i < 9; ++i)
      d_local[j].m[i] += d_coefficients[blends + 9 * (j - 1) + i];
    const Vec3<double> d_pose = flame_math::RodriguesVjp(tape.pose[j], d_local[j]);
    AddScaled(1, &d_pose.x, 3, d_frame + kFitPose + 3 * j);
    for (size_t i = 0; i < 3; ++i)
      AddScaled(d_joints[j][i],
                joint_directions_.data() + (3 * j + i) * blends + first,
                blends - first,
                &d_coefficients[first]);
  }
  AddScaled(1, d_point.data(), 3, d_frame + kFitTranslation);
  if (d_shape) AddScaled(1, d_coefficients.data(), size_t(shape_count_), d_shape);
  AddScaled(1,
            &d_coefficients[size_t(shape_count_)],
            size_t(expression_count_),
            d_frame + kFitExpression);
}

std::vector<std::array<int32_t, 3>> SkinFaces(const FlameModel& model) {
  const auto is_skin = [&](int32_t v) {
    const float* const weight = &model.skinning_weights[kFlameJoints * size_t(v)];
    return v < model.own_vertex_count() && weight[3] + weight[4] <= 0.01f;
  };
  std::vector<std::array<int32_t, 3>> faces;
  for (const std::array<int32_t, 3>& face : model.faces)
    if (std::all_of(face.begin(), face.end(), is_skin)) faces.push_back(face);
  return faces;
}

}  // namespace cosplat
