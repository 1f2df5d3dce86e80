#include "flame/fit/frame_priors.h"

#include <ceres/solver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "flame/fit/points_on_flame.h"

namespace cosplat::internal {
namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();

// Standard deviations of the joints' rotations about their rest, radians.
constexpr std::array<std::array<double, 3>, kFlameJoints> kJointSigma{{
    {kFree, kFree, kFree},  // root
    {0.01, 0.01, 0.01},     // neck: moves once the body has settled
    {0.2, 0.03, 0.03},      // jaw
    {0.3, 0.4, 0.01},       // left eye
    {0.3, 0.4, 0.01},       // right eye
}};

}  // namespace

PriorCost::PriorCost(std::vector<double> mean, const std::vector<double>& sigma)
    : mean_(std::move(mean)) {
  for (size_t k = 0; k < sigma.size(); ++k)
    if (std::isfinite(sigma[k])) {
      entries_.push_back(int(k));
      inverse_.push_back(1 / sigma[k]);
    }
  *mutable_parameter_block_sizes() = {int(mean_.size())};
  set_num_residuals(int(entries_.size()));
}

bool PriorCost::Evaluate(const double* const* parameters,
                         double* residuals,
                         double** jacobians) const {
  const size_t size = mean_.size();
  if (jacobians && jacobians[0]) std::fill_n(jacobians[0], entries_.size() * size, 0.0);
  for (size_t e = 0; e < entries_.size(); ++e) {
    const size_t k = size_t(entries_[e]);
    residuals[e] = (parameters[0][k] - mean_[k]) * inverse_[e];
    if (jacobians && jacobians[0]) jacobians[0][e * size + k] = inverse_[e];
  }
  return true;
}

std::vector<double> RestSigma(int frame_size, bool eyelids) {
  std::vector<double> sigma(size_t(frame_size), 1);
  std::fill_n(sigma.begin() + kFitTranslation, 3, kFree);
  for (size_t j = 0; j < kFlameJoints; ++j)
    std::copy_n(kJointSigma[j].begin(), 3, sigma.begin() + kFitPose + 3 * long(j));
  for (int k = 0; eyelids && k < 2; ++k) sigma[sigma.size() - 1 - size_t(k)] = 0.5;
  return sigma;
}

std::vector<double> StepSigma(int frame_size, bool eyelids) {
  std::vector<double> sigma(size_t(frame_size), 1.2);
  std::fill_n(sigma.begin() + kFitTranslation, 3, 0.003);
  std::fill_n(sigma.begin() + kFitPose, 6, 0.02);
  std::fill_n(sigma.begin() + kFitPose + 6, 3, 0.12);
  std::fill_n(sigma.begin() + kFitPose + 9, 6, 0.6);
  for (int k = 0; eyelids && k < 2; ++k) sigma[sigma.size() - 1 - size_t(k)] = 1.5;
  return sigma;
}

void SolveFrame(ceres::Problem& problem, int iterations) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = iterations;
  options.function_tolerance = 1e-5;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

}  // namespace cosplat::internal
