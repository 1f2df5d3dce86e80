#include "avatar/train/lbfgs.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cosplat::test {
namespace {

using Numbers = std::vector<double>;

// sum of w (x - at)^2 / 2, weights 1 to 100.
constexpr size_t kCount = 10;
Numbers GradientAt(const Numbers& x, double at) {
  Numbers gradient(kCount);
  for (size_t i = 0; i < kCount; ++i)
    gradient[i] = std::pow(100.0, double(i) / (kCount - 1)) * (x[i] - at);
  return gradient;
}

double NormOf(const Numbers& numbers) {
  double sum = 0;
  for (const double number : numbers) sum += number * number;
  return std::sqrt(sum);
}

// Full steps until the gradient's norm is below 1e-6.
int StepsTo(double at, Lbfgs& lbfgs) {
  Numbers x(kCount, 0.0), gradient = GradientAt(x, at);
  for (int step = 0; step < 100; ++step) {
    if (NormOf(gradient) < 1e-6) return step;
    Numbers change = gradient, by = lbfgs.StepAt(gradient, 0.01);
    for (size_t i = 0; i < kCount; ++i) x[i] += by[i];
    gradient = GradientAt(x, at);
    for (size_t i = 0; i < kCount; ++i) change[i] = gradient[i] - change[i];
    lbfgs.Learn(by, change);
  }
  return 100;
}

TEST(Lbfgs, TheFirstStepIsAgainstTheGradient) {
  const Numbers step = Lbfgs().StepAt({3, -4}, 10);
  EXPECT_NEAR(step[0], -6, 1e-12);
  EXPECT_NEAR(step[1], 8, 1e-12);
}

TEST(Lbfgs, KnowsAQuadraticFunctionBySomeSteps) {
  Lbfgs lbfgs;
  const int first = StepsTo(1, lbfgs);
  EXPECT_LE(first, 20);
  // Elsewhere it has the same second derivative.
  EXPECT_LT(StepsTo(-3, lbfgs), first);
  lbfgs.Forget();
  EXPECT_TRUE(lbfgs.knows_nothing());
}

TEST(Lbfgs, LearnsNothingWhereTheFunctionIsNotConvex) {
  Lbfgs lbfgs;
  lbfgs.Learn({1, 0}, {-1, 0});
  lbfgs.Learn({1, 0}, {0, 0});
  EXPECT_TRUE(lbfgs.knows_nothing());
}

}  // namespace
}  // namespace cosplat::test
