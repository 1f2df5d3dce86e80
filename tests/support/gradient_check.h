// Checks a vector-Jacobian product against dual numbers.
//
//   F:    std::vector<T> -> std::vector<T>, templated on T (a generic lambda or functor)
//   VJP:  (x, d_y) -> d_x, in double
// Accepted when |d_x - J^T d_y| <= tolerance * (1 + |J^T d_y|) for every input: relative for large
// derivatives, absolute for small ones. Both sides are double, so 1e-9 is the usual tolerance:
// rounding over a few hundred operations stays below it.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/dual.h"

namespace cosplat::test {

template <class F, class Vjp>
void ExpectVjpMatchesDual(const F& f,
                          const Vjp& vjp,
                          const std::vector<double>& x,
                          double tolerance = 1e-9,
                          unsigned seed = 1) {
  const std::vector<double> y = f(x);
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  std::vector<double> d_y(y.size());
  for (double& d : d_y) d = normal(rng);
  const std::vector<double> d_x = vjp(x, d_y);
  ASSERT_EQ(d_x.size(), x.size());
  for (size_t i = 0; i < x.size(); ++i) {
    std::vector<Dual> dual(x.begin(), x.end());
    dual[i].slope = 1;
    const std::vector<Dual> y_dual = f(dual);
    double expected = 0;
    for (size_t k = 0; k < y.size(); ++k) {
      EXPECT_NEAR(y_dual[k].value, y[k], 1e-12 * (1 + std::abs(y[k])));
      expected += d_y[k] * y_dual[k].slope;
    }
    EXPECT_TRUE(std::isfinite(d_x[i])) << "input " << i;
    EXPECT_NEAR(d_x[i], expected, tolerance * (1 + std::abs(expected))) << "input " << i;
  }
}

inline std::vector<double> RandomVector(size_t n, unsigned seed, double scale = 1) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal(0, scale);
  std::vector<double> v(n);
  for (double& x : v) x = normal(rng);
  return v;
}

}  // namespace cosplat::test
