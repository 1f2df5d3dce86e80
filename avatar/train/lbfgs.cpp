#include "avatar/train/lbfgs.h"

#include <cmath>
#include <numeric>
#include <utility>

namespace cosplat {
namespace {

constexpr size_t kPairs = 20;
// Of a number that changes nothing, as a share of the mean.
constexpr double kMinSquare = 1e-4;

double Dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

void Add(double factor, const std::vector<double>& a, std::vector<double>& sum) {
  for (size_t i = 0; i < sum.size(); ++i) sum[i] += factor * a[i];
}

void Scale(double factor, std::vector<double>& a) {
  for (double& number : a) number *= factor;
}

}  // namespace

std::vector<double> Lbfgs::StepAt(const std::vector<double>& gradient, double first_length) const {
  std::vector<double> step = gradient;
  if (pairs_.empty()) {
    Scale(-first_length / std::sqrt(Dot(gradient, gradient)), step);
    return step;
  }
  std::vector<double> along(pairs_.size());
  for (size_t k = pairs_.size(); k-- > 0;) {
    along[k] = Dot(pairs_[k].step, step) / pairs_[k].product;
    Add(-along[k], pairs_[k].gradient_change, step);
  }
  const std::vector<double> inverse = InverseDiagonal();
  for (size_t i = 0; i < step.size(); ++i) step[i] *= inverse[i];
  for (size_t k = 0; k < pairs_.size(); ++k) {
    const double against = Dot(pairs_[k].gradient_change, step) / pairs_[k].product;
    Add(along[k] - against, pairs_[k].step, step);
  }
  Scale(-1, step);
  return step;
}

std::vector<double> Lbfgs::InverseDiagonal() const {
  double mean = 0;
  for (const double square : squares_) mean += square / double(squares_.size());
  const Pair& last = pairs_.back();
  std::vector<double> inverse(squares_.size());
  double along = 0;
  for (size_t i = 0; i < inverse.size(); ++i) {
    inverse[i] = 1 / std::sqrt(squares_[i] / mean + kMinSquare);
    along += inverse[i] * last.gradient_change[i] * last.gradient_change[i];
  }
  Scale(last.product / along, inverse);
  return inverse;
}

void Lbfgs::Learn(std::vector<double> step, std::vector<double> gradient_change) {
  const double product = Dot(step, gradient_change);
  if (!(product > 1e-8 * Dot(gradient_change, gradient_change))) return;
  squares_.resize(step.size());
  const double length = Dot(step, step);
  for (size_t i = 0; i < step.size(); ++i)
    squares_[i] += gradient_change[i] * gradient_change[i] / length;
  pairs_.push_back({std::move(step), std::move(gradient_change), product});
  if (pairs_.size() > kPairs) pairs_.pop_front();
}

}  // namespace cosplat
