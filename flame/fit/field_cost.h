// Points of FLAME's surface that should meet a frame where one of its fields has a given value.
// Private to flame/fit/.
#pragma once

#include <memory>
#include <vector>

#include "flame/fit/frame_field.h"
#include "flame/fit/points_on_flame.h"

namespace cosplat::internal {

// A point that a frame shows, and what the field should be there.
struct FieldPoint {
  int point;
  double value, sigma;  // in the field's unit
};

// Parameters: shape [S], logarithm of the focal length in px [1], frame [frame_size].
// Residuals: one per point, in standard deviations, robust (flame/fit/robust.h).
class FieldCost : public ceres::CostFunction {
 public:
  // Keeps references to field and view. fixed_shape: so many numbers of the shape come before the
  // surface's own and change nothing.
  FieldCost(std::shared_ptr<const PointsOnFlame> surface,
            std::vector<FieldPoint> points,
            const FrameField& field,
            const FrameView& view,
            int fixed_shape = 0);
  // Fails if a point is not in front of the camera.
  bool Evaluate(const double* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const std::shared_ptr<const PointsOnFlame> surface_;
  const std::vector<FieldPoint> points_;
  const FrameField& field_;
  const FrameView& view_;
  const size_t fixed_shape_;
};

}  // namespace cosplat::internal
