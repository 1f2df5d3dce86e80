#include "avatar/model/bust.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "avatar/math/frame.h"
#include "avatar/math/one_euro.h"
#include "avatar/math/turn.h"

namespace cosplat {
namespace {

constexpr long kInputs = kBustInputs, kOutputs = kBustOutputs;
using Inputs = Eigen::Matrix<double, Eigen::Dynamic, kInputs>;
using Outputs = Eigen::Matrix<double, Eigen::Dynamic, kOutputs>;

constexpr long kBlocks = 5;
// Neighbouring instants are alike: those of a block count as four.
constexpr double kObservations = 4 * kBlocks;
constexpr std::array<double, 5> kDampings{HUGE_VAL, 10, 1, 0.1, 0.01};
// The most that an output can exceed its range, as a fraction of the range's width.
constexpr float kBustMargin = 0.25f;
constexpr float kMinBustMargin = 1e-6f;

// The head's root turn relative to the bust's mean, its translation, and the neck's turn.
std::array<float, kBustInputs> InputsOf(const Bust& bust, const FlameParams& params) {
  math::Mat3<float> mean;
  std::copy(bust.rotation.begin(), bust.rotation.end(), mean.m);
  const math::Quat<float> turn = math::Multiply(math::QuatOfAxisAngle(params.pose[0]),
                                                math::Conjugate(math::QuatOfRotation(mean)));
  const auto root = math::AxisAngleOf(math::ShorterWay(turn));
  const auto& t = params.translation;
  const auto& neck = params.pose[1];
  return {root[0], root[1], root[2], t[0], t[1], t[2], neck[0], neck[1], neck[2]};
}

std::array<float, kBustOutputs> OutputsOf(const BustPose& pose) {
  const auto turn = math::AxisAngleOf(math::ShorterWay(pose.turn));
  return {turn[0], turn[1], turn[2], pose.shift.x, pose.shift.y, pose.shift.z};
}

struct LinearMap {
  Eigen::Matrix<double, 1, kInputs> input_mean;
  Eigen::Matrix<double, kInputs, 1> slope;
  double output_mean;
};

// Ridge regression on inputs of unit variance; with infinite damping, the outputs' mean.
LinearMap FitRidge(const Inputs& x, const Eigen::VectorXd& y, double damping) {
  const double n = double(x.rows());
  LinearMap map{x.colwise().mean(), Eigen::Matrix<double, kInputs, 1>::Zero(), y.mean()};
  if (std::isinf(damping)) return map;
  const Inputs centered = x.rowwise() - map.input_mean;
  Eigen::Matrix<double, kInputs, 1> scale =
      (centered.colwise().squaredNorm() / n).cwiseSqrt().transpose();
  for (double& s : scale) s = s > 1e-9 ? 1 / s : 0;
  const Inputs z = centered * scale.asDiagonal();
  Eigen::Matrix<double, kInputs, kInputs> normal = z.transpose() * z / n;
  normal.diagonal().array() += damping;
  const Eigen::VectorXd of_y = z.transpose() * (y.array() - map.output_mean).matrix() / n;
  map.slope = scale.asDiagonal() * normal.ldlt().solve(of_y);
  return map;
}

// Sum of the squared errors with which the other instants predict those of a block.
double ErrorOfBlock(
    const Inputs& x, const Eigen::VectorXd& y, double damping, long begin, long count) {
  const long after = x.rows() - begin - count;
  Inputs x_rest(begin + after, kInputs);
  Eigen::VectorXd y_rest(begin + after);
  x_rest << x.topRows(begin), x.bottomRows(after);
  y_rest << y.head(begin), y.tail(after);
  const LinearMap map = FitRidge(x_rest, y_rest, damping);
  const Eigen::VectorXd predicted =
      ((x.middleRows(begin, count).rowwise() - map.input_mean) * map.slope).array() +
      map.output_mean;
  return (predicted - y.segment(begin, count)).squaredNorm();
}

// The maps of all dampings, each weighted by how likely the other blocks' errors make it:
// exp(-n / 2 (E / E_best - 1)), with n independent observations. The best one alone changes from
// seed to seed, and can take a motion for noise; equal weights follow shoulders that move on their
// own.
LinearMap FitWeighted(const Inputs& x, const Eigen::VectorXd& y) {
  LinearMap mean = FitRidge(x, y, HUGE_VAL);
  const long n = x.rows();
  if (n < 2 * kBlocks) return mean;
  std::array<double, kDampings.size()> error{};
  for (size_t d = 0; d < kDampings.size(); ++d)
    for (long b = 0; b < kBlocks; ++b) {
      const long begin = b * n / kBlocks;
      error[d] += ErrorOfBlock(x, y, kDampings[d], begin, (b + 1) * n / kBlocks - begin);
    }
  const double best = std::max(*std::min_element(error.begin(), error.end()), 1e-30);
  double sum = 0;
  for (size_t d = 0; d < kDampings.size(); ++d) {
    const double weight = std::exp(-0.5 * kObservations * (error[d] / best - 1));
    mean.slope += weight * FitRidge(x, y, kDampings[d]).slope;
    sum += weight;
  }
  mean.slope /= sum;
  return mean;
}

}  // namespace

BustPose PoseOfBust(const Bust& bust, const FlameParams& params) {
  if (!bust.follow) return kMeanBustPose;
  const BustFollow& f = *bust.follow;
  const auto inputs = InputsOf(bust, params);
  std::array<float, kBustOutputs> out = f.mean;
  for (size_t r = 0; r < kBustOutputs; ++r) {
    for (size_t c = 0; c < kBustInputs; ++c)
      out[r] += f.matrix[kBustInputs * r + c] * (inputs[c] - f.head_mean[c]);
    const float margin = std::max(kMinBustMargin, kBustMargin * (f.max[r] - f.min[r]));
    out[r] = math::SoftClamp(out[r], f.min[r], f.max[r], margin);
  }
  return {math::QuatOfAxisAngle({out[0], out[1], out[2]}), {out[3], out[4], out[5]}};
}

void HoldBustStill(AvatarModel& avatar) {
  if (!avatar.bust || !avatar.bust->follow) return;
  BustFollow& follow = *avatar.bust->follow;
  follow.matrix = {};
  follow.min = follow.max = follow.mean;
}

BustFollow FitBustFollow(const Bust& bust,
                         const std::vector<FlameParams>& heads,
                         const std::vector<BustPose>& busts) {
  Inputs x(heads.size(), kInputs);
  Outputs y(heads.size(), kOutputs);
  for (size_t i = 0; i < heads.size(); ++i) {
    const auto in = InputsOf(bust, heads[i]);
    const auto out = OutputsOf(busts[i]);
    for (size_t k = 0; k < kBustInputs; ++k) x(long(i), long(k)) = in[k];
    for (size_t k = 0; k < kBustOutputs; ++k) y(long(i), long(k)) = out[k];
  }
  BustFollow follow;
  for (size_t r = 0; r < kBustOutputs; ++r) {
    const Eigen::VectorXd output = y.col(long(r));
    const LinearMap map = FitWeighted(x, output);
    for (size_t c = 0; c < kBustInputs; ++c) {
      follow.head_mean[c] = float(map.input_mean[long(c)]);
      follow.matrix[kBustInputs * r + c] = float(map.slope[long(c)]);
    }
    follow.mean[r] = float(map.output_mean);
    follow.min[r] = float(output.minCoeff());
    follow.max[r] = float(output.maxCoeff());
  }
  return follow;
}

}  // namespace cosplat
