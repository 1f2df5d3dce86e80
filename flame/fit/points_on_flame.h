// Single points of FLAME's surface as functions of shape, expression, pose and translation, with
// their derivatives: what a fit to landmarks needs, at a hundredth of the whole mesh's cost.
//
// LandmarkEmbedding -> PointsOnFlame::Pose -> [L, 3]; PointsOnFlame::Backward per point. The
// formulas are those of FlamePoser (flame/math/), evaluated at the points' vertices only.
#pragma once

#include <array>
#include <vector>

#include "flame/fit/landmark_embedding.h"
#include "flame/math/kinematics.h"
#include "flame/model.h"

namespace cosplat {

// A frame's numbers in one row: translation, joints, expression.
constexpr int kFitTranslation = 0, kFitPose = 3, kFitExpression = kFitPose + 3 * kFlameJoints;

// Such a row as pose, translation and expression; leaves the eyelids.
void SetFromRow(const std::vector<double>& row, FlameParams& params);

class PointsOnFlame {
 public:
  // Uses the first `shape_count` and `expression_count` directions of the model; with eyelids, the
  // last two coefficients are theirs.
  PointsOnFlame(const FlameModel& model,
                const LandmarkEmbedding& embedding,
                int shape_count,
                int expression_count);

  // Some of the points, of one shape: it has no shape numbers any more.
  PointsOnFlame Part(const std::vector<int>& points, const double* shape) const;

  int point_count() const { return int(corners_.size()); }
  int shape_count() const { return shape_count_; }
  int frame_size() const { return kFitExpression + expression_count_; }

  // What Backward needs of Pose.
  struct Tape {
    std::array<math::Vec3<double>, kFlameJoints> pose, joints;
    std::array<math::Mat3<double>, kFlameJoints> local;
    flame_math::JointTransforms<double, kFlameJoints> transforms;
    std::vector<double> unskinned;              // [vertices, 3]
    std::vector<std::array<double, 3>> points;  // [L] metres, as FlamePoser poses them
  };
  // shape [shape_count], frame [frame_size].
  void Pose(const double* shape, const double* frame, Tape& tape) const;

  // Adds d_point^T d(points[point]) / d(shape, frame) to d_shape, if it is not null, and d_frame.
  void Backward(const Tape& tape,
                int point,
                const std::array<double, 3>& d_point,
                double* d_shape,
                double* d_frame) const;

 private:
  PointsOnFlame() = default;
  struct Corner {
    int vertex;  // of those that are kept
    double weight;
  };
  // Per coordinate: shape, expression and pose directions side by side, so that a derivative is a
  // sum of rows.
  size_t columns() const { return size_t(shape_count_ + expression_count_) + kFlamePoseFeatures; }

  int shape_count_ = 0, expression_count_ = 0;
  std::array<int, kFlameJoints> parents_{};
  std::vector<std::array<Corner, 3>> corners_;  // [L]
  std::vector<double> template_;                // [vertices, 3]
  std::vector<double> directions_;              // [vertices, 3, columns]
  std::vector<double> weights_;                 // [vertices, kFlameJoints]
  std::array<double, 3 * kFlameJoints> rest_joints_{};
  std::vector<double> joint_directions_;  // [15, shape_count + expression_count]
};

// The triangles that a camera can compare, of head, neck and chest: without the eyes, which turn on
// their own, and without an added mouth.
std::vector<std::array<int32_t, 3>> SkinFaces(const FlameModel& model);

}  // namespace cosplat
