#include "avatar/model/corrections.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "avatar/math/one_euro.h"

namespace cosplat {
namespace {

using Parameters = FlamePoser<float>::Parameters;

// Components that move the mesh less are rounding: variance in square metres, and as a share of the
// largest.
constexpr double kMinVariance = 1e-14;
constexpr double kMinShare = 1e-6;
// The most that a weight can exceed its range, as a fraction of the range's width.
constexpr float kWeightMargin = 0.25f;
// A basis that is weaker than this share of the strongest one is dropped after training.
constexpr double kIdleShare = 0.01;

// Number i of `count` inputs: expression, then axis-angles of neck, jaw and eyes.
float InputAt(const Parameters& p, size_t i, size_t count) {
  const size_t expressions = count - kMinCorrectionInputs;
  if (i < expressions) return i < p.expression.size() ? p.expression[i] : 0;
  return p.pose[1 + (i - expressions) / 3][(i - expressions) % 3];
}

double Rms(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::pow(double(a[i]) - b[i], 2);
  return std::sqrt(sum / double(a.size()));
}

// How far one unit of each input moves the mesh: the root mean square over its coordinates, metres.
Eigen::VectorXd ReachOf(const FlameModel& flame, size_t count) {
  constexpr float kStep = 0.1f;
  const FlamePoser<float> poser(flame, {});
  std::vector<float> rest, moved;
  poser.Forward({}, rest);
  Eigen::VectorXd reach(static_cast<long>(count));
  const size_t expressions = count - kMinCorrectionInputs;
  for (size_t i = 0; i < count; ++i) {
    Parameters p;
    p.expression.assign(expressions, 0.0f);
    (i < expressions ? p.expression[i] : p.pose[1 + (i - expressions) / 3][(i - expressions) % 3]) =
        kStep;
    poser.Forward(p, moved);
    reach[long(i)] = Rms(rest, moved) / kStep;
  }
  return reach;
}

// How much each basis does: the sum of its squared numbers over the Gaussians, times the square of
// its largest weight.
std::vector<double> StrengthsOf(const AvatarModel& avatar) {
  const Buffer<float>& bases = avatar.gaussians.values[kCorrection];
  const CorrectionMap& map = avatar.correction_map;
  std::vector<double> strengths(map.count());
  for (size_t i = 0; i < bases.size(); ++i)
    strengths[i / kCorrectionNumbers % map.count()] += double(bases[i]) * bases[i];
  for (size_t k = 0; k < map.count(); ++k)
    strengths[k] *= std::pow(std::max(std::abs(map.min[k]), std::abs(map.max[k])), 2);
  return strengths;
}

}  // namespace

CorrectionMap FindCorrectionMap(const FlameModel& flame,
                                const std::vector<Parameters>& frames,
                                size_t count) {
  const size_t inputs = size_t(flame.expression_count) + kMinCorrectionInputs;
  Eigen::MatrixXd z(frames.size(), inputs);
  for (size_t f = 0; f < frames.size(); ++f)
    for (size_t i = 0; i < inputs; ++i) z(long(f), long(i)) = InputAt(frames[f], i, inputs);
  const Eigen::RowVectorXd mean = z.colwise().mean();
  z.rowwise() -= mean;
  const Eigen::RowVectorXd reach = ReachOf(flame, inputs).transpose();
  const Eigen::MatrixXd moved = z.array().rowwise() * reach.array();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(moved.transpose() * moved /
                                                              double(frames.size()));
  CorrectionMap map;
  map.mean.assign(mean.data(), mean.data() + inputs);
  const double largest = solver.eigenvalues().maxCoeff();
  for (size_t k = 0; k < std::min(count, inputs); ++k) {
    const long column = long(inputs - 1 - k);  // the largest first
    const double variance = solver.eigenvalues()[column];
    if (!(variance > kMinVariance && variance > kMinShare * largest)) break;
    Eigen::VectorXd row = solver.eigenvectors().col(column).array() * reach.transpose().array();
    Eigen::VectorXd weights = z * row;
    const double max = weights.cwiseAbs().maxCoeff();
    row /= max;
    weights /= max;
    map.matrix.insert(map.matrix.end(), row.data(), row.data() + inputs);
    map.min.push_back(float(weights.minCoeff()));
    map.max.push_back(float(weights.maxCoeff()));
  }
  return map;
}

void CorrectionWeights(const CorrectionMap& map,
                       const Parameters& parameters,
                       std::vector<float>& weights) {
  const size_t inputs = map.mean.size();
  weights.resize(map.count());
  for (size_t k = 0; k < weights.size(); ++k) {
    double sum = 0;
    for (size_t i = 0; i < inputs; ++i)
      sum += double(map.matrix[k * inputs + i]) *
             (double(InputAt(parameters, i, inputs)) - map.mean[i]);
    const float margin = kWeightMargin * (map.max[k] - map.min[k]);
    weights[k] = math::SoftClamp(float(sum), map.min[k], map.max[k], margin);
  }
}

void DropIdleCorrections(AvatarModel& avatar) {
  const std::vector<double> strengths = StrengthsOf(avatar);
  if (strengths.empty()) return;
  const double min =
      kIdleShare * kIdleShare * *std::max_element(strengths.begin(), strengths.end());
  const CorrectionMap& map = avatar.correction_map;
  const size_t inputs = map.mean.size();
  CorrectionMap kept{map.mean, {}, {}, {}};
  std::vector<size_t> from;
  for (size_t k = 0; k < strengths.size(); ++k) {
    if (strengths[k] <= min) continue;
    from.push_back(k);
    const auto row = map.matrix.begin() + std::ptrdiff_t(k * inputs);
    kept.matrix.insert(kept.matrix.end(), row, row + std::ptrdiff_t(inputs));
    kept.min.push_back(map.min[k]);
    kept.max.push_back(map.max[k]);
  }
  Buffer<float> bases;
  for (size_t i = 0; i < avatar.size(); ++i)
    for (const size_t k : from) {
      const float* numbers = avatar.gaussians.at(kCorrection, i) + k * kCorrectionNumbers;
      for (int j = 0; j < kCorrectionNumbers; ++j) bases.push_back(numbers[j]);
    }
  avatar.gaussians.values[kCorrection] = std::move(bases);
  avatar.gaussians.corrections = int(from.size());
  avatar.correction_map = from.empty() ? CorrectionMap{} : std::move(kept);
}

}  // namespace cosplat
