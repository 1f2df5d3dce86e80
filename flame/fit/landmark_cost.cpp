#include "flame/fit/landmark_cost.h"

#include <algorithm>
#include <cmath>

#include "flame/fit/robust.h"

namespace cosplat::internal {

LandmarkCost::LandmarkCost(const PointsOnFlame& points,
                           const LandmarkEmbedding& embedding,
                           const ObservedFace& face,
                           const FitLens& lens,
                           double sigma)
    : points_(points), embedding_(embedding), face_(face), lens_(lens), sigma_(sigma) {
  *mutable_parameter_block_sizes() = {points.shape_count(), 1, points.frame_size()};
  set_num_residuals(2 * points.point_count());
}

bool LandmarkCost::Evaluate(const double* const* parameters,
                            double* residuals,
                            double** jacobians) const {
  PointsOnFlame::Tape tape;
  points_.Pose(parameters[0], parameters[2], tape);
  const double focal = std::exp(parameters[1][0]);
  const size_t shape = size_t(points_.shape_count()), frame = size_t(points_.frame_size());
  // A row of the Jacobian is summed here.
  std::vector<double> d_shape(2 * shape), d_frame(2 * frame);
  for (size_t p = 0; p < embedding_.size(); ++p) {
    const auto& [x, y, z] = tape.points[p];
    if (-z < kMinDistance) return false;
    const size_t landmark = size_t(embedding_[p].landmark);
    const double k = face_.weights[landmark] / (sigma_ * embedding_[p].looseness),
                 scale = focal / -z;
    const auto& seen = face_.points[landmark];
    const double r[2] = {k * (lens_.cx + scale * x - seen[0]),
                         k * (lens_.cy - scale * y - seen[1])};
    double d_factor;
    const double factor = RobustFactor(r[0] * r[0] + r[1] * r[1], d_factor);
    for (size_t i = 0; i < 2; ++i) residuals[2 * p + i] = factor * r[i];
    if (!jacobians) continue;
    // Derivatives of r with respect to the point and the focal length.
    const std::array<double, 3> d_point[2] = {{k * scale, 0, k * scale * x / -z},
                                              {0, -k * scale, -k * scale * y / -z}};
    const double d_focal[2] = {k * scale * x, -k * scale * y};
    // Derivatives of the residuals with respect to r.
    double d_robust[2][2];
    for (size_t i = 0; i < 2; ++i)
      for (size_t j = 0; j < 2; ++j)
        d_robust[i][j] = (i == j ? factor : 0) + 2 * d_factor * r[i] * r[j];
    for (size_t i = 0; i < 2; ++i) {
      std::array<double, 3> d{};
      for (size_t j = 0; j < 2; ++j)
        for (size_t a = 0; a < 3; ++a) d[a] += d_robust[i][j] * d_point[j][a];
      std::fill_n(d_shape.begin(), shape, 0.0);
      std::fill_n(d_frame.begin(), frame, 0.0);
      points_.Backward(tape, int(p), d, jacobians[0] ? d_shape.data() : nullptr, d_frame.data());
      const size_t row = 2 * p + i;
      if (jacobians[0]) std::copy_n(d_shape.begin(), shape, jacobians[0] + row * shape);
      if (jacobians[1])
        jacobians[1][row] = d_robust[i][0] * d_focal[0] + d_robust[i][1] * d_focal[1];
      if (jacobians[2]) std::copy_n(d_frame.begin(), frame, jacobians[2] + row * frame);
    }
  }
  return true;
}

}  // namespace cosplat::internal
