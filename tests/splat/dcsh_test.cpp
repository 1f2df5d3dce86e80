// The colour bases: against Boost-free references, against each other, and their derivatives.
#include "splat/math/dcsh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/gradient_check.h"

namespace cosplat::math {
namespace {

using test::ExpectVjpMatchesDual;
using test::RandomVector;

Vec3<double> RandomDirection(unsigned seed) {
  const auto v = RandomVector(3, seed);
  return Normalize(Vec3<double>{v[0], v[1], v[2]});
}

// Y_l^m from angles, as the paper's formula with atan2: K P_l^|m|(cos t) {cos, sin}(|m| phi).
double FromAngles(int l, int m, const Vec3<double>& u) {
  const double phi = std::atan2(u.y, u.x);
  double ratio = 1;
  for (int i = l - std::abs(m) + 1; i <= l + std::abs(m); ++i) ratio /= i;
  const double k = std::sqrt((2 * l + 1) / (4 * M_PI) * ratio * (m ? 2 : 1));
  // std::assoc_legendre has no Condon-Shortley sign.
  const double p = std::assoc_legendre(l, std::abs(m), u.z);
  return k * p * (m >= 0 ? std::cos(m * phi) : std::sin(-m * phi));
}

TEST(Dcsh, EqualsTheAngularFormToDegreeSix) {
  for (unsigned seed = 1; seed < 20; ++seed) {
    const Vec3<double> u = RandomDirection(seed);
    double basis[49];
    EvaluateBasis<6>(u, BasisConstants(Basis::kDcsh), basis);
    for (int l = 0; l <= 6; ++l)
      for (int m = -l; m <= l; ++m)
        EXPECT_NEAR(
            basis[l * l + l + m], FromAngles(l, m, u) * (l ? std::sqrt(4 * M_PI) : 1.0), 2e-6)
            << l << ' ' << m;  // float constants: 6e-8 relative of values up to 13
  }
}

TEST(Sh, Equals3dgsPolynomials) {
  const Vec3<double> u = RandomDirection(5);
  const double x = u.x, y = u.y, z = u.z;
  double b[16];
  EvaluateBasis<3>(u, BasisConstants(Basis::kSh), b);
  const double expected[16] = {0.28209479177387814,
                               -0.4886025119029199 * y,
                               0.4886025119029199 * z,
                               -0.4886025119029199 * x,
                               1.0925484305920792 * x * y,
                               -1.0925484305920792 * y * z,
                               0.31539156525252005 * (2 * z * z - x * x - y * y),
                               -1.0925484305920792 * x * z,
                               0.5462742152960396 * (x * x - y * y),
                               -0.5900435899266435 * y * (3 * x * x - y * y),
                               2.890611442640554 * x * y * z,
                               -0.4570457994644658 * y * (4 * z * z - x * x - y * y),
                               0.3731763325901154 * z * (2 * z * z - 3 * x * x - 3 * y * y),
                               -0.4570457994644658 * x * (4 * z * z - x * x - y * y),
                               1.445305721320277 * z * (x * x - y * y),
                               -0.5900435899266435 * x * (x * x - 3 * y * y)};
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(b[i], expected[i], 2e-7) << i;
}

TEST(Dcsh, IsN3dWithoutSigns) {
  const float* dcsh = BasisConstants(Basis::kDcsh);
  const float* sh = BasisConstants(Basis::kSh);
  EXPECT_FLOAT_EQ(dcsh[0], sh[0]);
  for (int l = 1; l <= 6; ++l)
    for (int m = -l; m <= l; ++m) {
      const int i = l * l + l + m;
      EXPECT_NEAR(dcsh[i] / sh[i], (m % 2 ? -1 : 1) * std::sqrt(4 * M_PI), 1e-6) << i;
    }
  // Band 1 with N3D: sqrt(3) times the direction cosine.
  double b[4];
  EvaluateBasis<1>(Vec3<double>{1, 0, 0}, dcsh, b);
  EXPECT_NEAR(b[3], std::sqrt(3.0), 1e-6);
}

TEST(Dcsh, AdditionTheoremHolds) {
  // Sum over m of N3D Y^2 is 2l+1 in every direction: no singular one.
  for (const Vec3<double>& u :
       {Vec3<double>{0, 0, 1}, Vec3<double>{0, 0, -1}, Vec3<double>{0, 1, 0}, RandomDirection(3)}) {
    double b[49];
    EvaluateBasis<6>(u, BasisConstants(Basis::kDcsh), b);
    for (int l = 1; l <= 6; ++l) {
      double sum = 0;
      for (int i = l * l; i < (l + 1) * (l + 1); ++i) sum += b[i] * b[i];
      EXPECT_NEAR(sum, 2 * l + 1, 1e-5);
    }
  }
}

template <int kDegree>
void CheckColorVjp(Basis basis) {
  constexpr int kRest = (kDegree + 1) * (kDegree + 1) - 1;
  const float* constants = BasisConstants(basis);
  // x: direction (normalised inside), dc, rest.
  const auto f = [constants](const auto& x) {
    using T = typename std::decay_t<decltype(x)>::value_type;
    const auto u = Normalize(Vec3<T>{x[0], x[1], x[2]});
    const auto c = EvaluateColor<kDegree>(u, constants, x.data() + 3, x.data() + 6);
    return std::vector<T>{c.x, c.y, c.z};
  };
  const auto vjp = [constants](const std::vector<double>& x, const std::vector<double>& d) {
    const Vec3<double> v{x[0], x[1], x[2]};
    const auto u = Normalize(v);
    const auto color = EvaluateColor<kDegree>(u, constants, x.data() + 3, x.data() + 6);
    std::vector<double> d_x(x.size());
    const auto d_u = EvaluateColorVjp<kDegree>(u,
                                               constants,
                                               x.data() + 6,
                                               color,
                                               Vec3<double>{d[0], d[1], d[2]},
                                               d_x.data() + 3,
                                               d_x.data() + 6);
    const auto d_v = NormalizeVjp(v, d_u);
    d_x[0] = d_v.x;
    d_x[1] = d_v.y;
    d_x[2] = d_v.z;
    return d_x;
  };
  for (unsigned seed = 1; seed < 5; ++seed)
    ExpectVjpMatchesDual(f, vjp, RandomVector(6 + 3 * kRest, seed, 0.3));
}

TEST(Dcsh, ColorVjp) {
  for (const Basis basis : {Basis::kDcsh, Basis::kSh}) {
    CheckColorVjp<0>(basis);
    CheckColorVjp<1>(basis);
    CheckColorVjp<3>(basis);
    CheckColorVjp<4>(basis);
    CheckColorVjp<6>(basis);
  }
}

}  // namespace
}  // namespace cosplat::math
