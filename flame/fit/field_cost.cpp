#include "flame/fit/field_cost.h"

#include <algorithm>
#include <cmath>

#include "flame/fit/robust.h"

namespace cosplat::internal {

FieldCost::FieldCost(std::shared_ptr<const PointsOnFlame> surface,
                     std::vector<FieldPoint> points,
                     const FrameField& field,
                     const FrameView& view,
                     int fixed_shape)
    : surface_(std::move(surface)),
      points_(std::move(points)),
      field_(field),
      view_(view),
      fixed_shape_(size_t(fixed_shape)) {
  *mutable_parameter_block_sizes() = {
      fixed_shape + surface_->shape_count(), 1, surface_->frame_size()};
  set_num_residuals(int(points_.size()));
}

bool FieldCost::Evaluate(const double* const* parameters,
                         double* residuals,
                         double** jacobians) const {
  PointsOnFlame::Tape tape;
  surface_->Pose(parameters[0] + fixed_shape_, parameters[2], tape);
  const double focal = std::exp(parameters[1][0]);
  const size_t shape = fixed_shape_ + size_t(surface_->shape_count());
  const size_t frame = size_t(surface_->frame_size());
  std::vector<double> d_shape(shape), d_frame(frame);
  for (size_t row = 0; row < points_.size(); ++row) {
    const FieldPoint& point = points_[row];
    const auto [x, y, z] = InView(view_, tape.points[size_t(point.point)]);
    if (-z < kMinDistance) return false;
    const double scale = focal / -z;
    const FieldAt at = SampleAt(field_, view_.lens.cx + scale * x, view_.lens.cy - scale * y);
    const double r = at.inside ? (at.value - point.value) / point.sigma : 0;
    double d_factor;
    const double factor = RobustFactor(r * r, d_factor);
    residuals[row] = factor * r;
    if (!jacobians) continue;
    const double d_value = (factor + 2 * d_factor * r * r) / point.sigma;
    // By the place in the image, as it moves to the right and up.
    const double d_right = d_value * at.d_x * scale, d_up = -d_value * at.d_y * scale;
    const double d_nearer = d_right * x + d_up * y;
    std::fill(d_shape.begin(), d_shape.end(), 0.0);
    std::fill(d_frame.begin(), d_frame.end(), 0.0);
    surface_->Backward(tape,
                       point.point,
                       InViewVjp(view_, {d_right, d_up, d_nearer / -z}),
                       jacobians[0] ? d_shape.data() + fixed_shape_ : nullptr,
                       d_frame.data());
    if (jacobians[0]) std::copy_n(d_shape.begin(), shape, jacobians[0] + row * shape);
    if (jacobians[1]) jacobians[1][row] = d_nearer;
    if (jacobians[2]) std::copy_n(d_frame.begin(), frame, jacobians[2] + row * frame);
  }
  return true;
}

}  // namespace cosplat::internal
