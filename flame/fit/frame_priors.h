// What a frame's numbers stay near, in the fits of flame/fit/. Private to flame/fit/.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/problem.h>

#include <cstddef>
#include <vector>

namespace cosplat::internal {

// (x_k - mean_k) / sigma_k for every k whose sigma is finite.
class PriorCost : public ceres::CostFunction {
 public:
  PriorCost(std::vector<double> mean, const std::vector<double>& sigma);
  bool Evaluate(const double* const* parameters,
                double* residuals,
                double** jacobians) const override;

 private:
  std::vector<double> mean_;
  std::vector<int> entries_;
  std::vector<double> inverse_;  // of sigma, per entry
};

// What the numbers of frames stay near, and by how much.
struct FramePrior {
  std::vector<std::vector<double>> rests;  // per frame
  std::vector<double> rest_sigma;          // about its rest
  std::vector<double> step_sigma;          // about its neighbours
};

// Standard deviations of a frame's numbers (PointsOnFlame's) about their rest; some are free.
std::vector<double> RestSigma(int frame_size, bool eyelids);
// Standard deviations of a frame's numbers (PointsOnFlame's) about the mean of the neighbouring
// frames', at video rates. Eyes and lids jump.
std::vector<double> StepSigma(int frame_size, bool eyelids);

// The mean of frame f's neighbours; nothing if one is missing. follows: whether a frame shows the
// same face a moment after the frame before it.
template <class Follows>
std::vector<double> BetweenNeighbours(const std::vector<std::vector<double>>& frames,
                                      size_t f,
                                      const Follows& follows) {
  const bool inside =
      f > 0 && f + 1 < frames.size() && !frames[f - 1].empty() && !frames[f + 1].empty();
  if (!inside || !follows(f) || !follows(f + 1)) return {};
  std::vector<double> mean(frames[f].size());
  for (size_t k = 0; k < mean.size(); ++k) mean[k] = (frames[f - 1][k] + frames[f + 1][k]) / 2;
  return mean;
}

// Fits the blocks of a problem that are not constant: numbers of one frame.
void SolveFrame(ceres::Problem& problem, int iterations);

}  // namespace cosplat::internal
