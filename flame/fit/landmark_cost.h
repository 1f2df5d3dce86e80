// Residuals of the fit to landmarks, for Ceres. Private to flame/fit/.
#pragma once

#include <ceres/cost_function.h>

#include <vector>

#include "flame/fit/choose_faces.h"
#include "flame/fit/points_on_flame.h"

namespace cosplat::internal {

// The camera stands still at the origin with OpenGL's axes: x right, y up, looking along -z.
struct FitLens {
  double cx, cy;  // px
};
constexpr double kMinDistance = 0.02;  // metres, of a point from the camera

// Parameters: shape [S], logarithm of the focal length in px [1], frame [frame_size].
// Residuals: two per landmark, px over `sigma`, robust as a pair (flame/fit/robust.h).
class LandmarkCost : public ceres::CostFunction {
 public:
  // Keeps references to all but the numbers.
  LandmarkCost(const PointsOnFlame& points,
               const LandmarkEmbedding& embedding,
               const ObservedFace& face,
               const FitLens& lens,
               double sigma);
  // Fails if a point is not in front of the camera.
  bool Evaluate(const double* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  const PointsOnFlame& points_;
  const LandmarkEmbedding& embedding_;
  const ObservedFace& face_;
  const FitLens lens_;
  const double sigma_;
};

}  // namespace cosplat::internal
