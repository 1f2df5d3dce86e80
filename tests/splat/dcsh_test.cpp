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

// Along the sphere, by second differences in two directions.
TEST(Dcsh, TheSpheresLaplacianMultipliesABandByItsEigenvalue) {
  const double step = 1e-3;
  const Vec3<double> u = RandomDirection(4);
  const Vec3<double> a = Normalize(Vec3<double>{-u.y, u.x, 0}), b = Cross(u, a);
  double at[16], sum[16] = {};
  EvaluateBasis<3>(u, BasisConstants(Basis::kDcsh), at);
  for (const Vec3<double>& along : {a, b, -a, -b}) {
    double near[16];
    EvaluateBasis<3>(Normalize(u + along * std::tan(step)), BasisConstants(Basis::kDcsh), near);
    for (int k = 0; k < 16; ++k) sum[k] += (near[k] - at[k]) / (step * step);
  }
  for (int l = 0; l <= 3; ++l)
    for (int k = l * l; k < (l + 1) * (l + 1); ++k)
      EXPECT_NEAR(sum[k], -l * (l + 1) * at[k], 1e-4) << k;
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

// As DCSHARP's released code has them, before the polynomials named in docs/dcsh.md.
TEST(DcshReleased, HasTheReleasedConstants) {
  const double released[16] = {0.28209479,
                               1.7320508,
                               1.7320508,
                               1.7320508,
                               3.8729833,
                               3.8729833,
                               1.1180340,
                               3.8729833,
                               1.1180340,
                               2.0916501,
                               5.1234561,
                               1.6201852,
                               1.3228757,
                               1.6201852,
                               5.1234561,
                               2.0916501};
  const Vec3<double> u = RandomDirection(7);
  const double x = u.x, y = u.y, z = u.z;
  const double polynomial[16] = {1,
                                 y,
                                 z,
                                 x,
                                 x * y,
                                 y * z,
                                 3 * z * z - 1,
                                 x * z,
                                 x * x - y * y,
                                 y * (3 * x * x - y * y),
                                 x * y * z,
                                 y * (5 * z * z - 1),
                                 z * (5 * z * z - 3),
                                 x * (5 * z * z - 1),
                                 z * (x * x - y * y),
                                 x * (x * x - 3 * y * y)};
  double b[16];
  EvaluateBasis<3>(u, BasisConstants(Basis::kDcshReleased), b);
  for (int k = 0; k < 16; ++k) EXPECT_NEAR(b[k] / polynomial[k], released[k], 5e-7) << k;
}

TEST(DcshReleased, DiffersFromDcshInItsSlipsAlone) {
  for (int k = 0; k < kMaxCoefficients; ++k) {
    const double ratio =
        BasisConstants(Basis::kDcshReleased)[k] / double(BasisConstants(Basis::kDcsh)[k]);
    const double expected = k == 8    ? 1.1180340 / 1.9364917
                            : k == 10 ? 5.1234561 / 10.2469508
                            : k == 14 ? 5.1234561 / 5.1234754
                                      : 1;
    EXPECT_NEAR(ratio, expected, 1e-7) << k;
  }
}

// The published formula to the letter: sqrt2 N P_l^|m|(z) {cos, sin}(|m| arctan(y/x)), 0/0 = 0.
long double Literal(int l, int m, const Vec3<double>& u) {
  const int order = std::abs(m);
  long double ratio = 1;
  for (int i = l - order + 1; i <= l + order; ++i) ratio /= i;
  const long double n = std::sqrt((2 * l + 1) / (4 * std::acos(-1.0L)) * ratio * (m ? 2 : 1));
  const long double p = std::assoc_legendre(l, order, static_cast<long double>(u.z));
  const long double angle = std::atan(static_cast<long double>(u.y) / u.x);
  return n * p * (m == 0 ? 1 : m > 0 ? std::cos(m * angle) : std::sin(order * angle));
}

void EvaluateLiteral(const Vec3<double>& u, double* basis) {
  EvaluateBasis<6>(Fold(u), BasisConstants(Basis::kDcshLiteral), basis);
}

TEST(DcshLiteral, IsTheArctanFormAsAPolynomialOfTheFoldedDirection) {
  int behind = 0;
  for (unsigned seed = 1; seed < 200; ++seed) {
    const Vec3<double> u = RandomDirection(seed);
    behind += u.x < 0;
    double basis[49];
    EvaluateLiteral(u, basis);
    for (int l = 0; l <= 6; ++l)
      for (int m = -l; m <= l; ++m)
        EXPECT_NEAR(basis[l * l + l + m], double(Literal(l, m, u)), 1e-6) << l << ' ' << m;
  }
  EXPECT_GT(behind, 50);
  // At the poles everything that has an azimuth is 0.
  for (const double z : {1.0, -1.0}) {
    double pole[49];
    EvaluateLiteral({0, 0, z}, pole);
    for (int l = 1; l <= 6; ++l)
      for (int m = 1; m <= l; ++m) {
        EXPECT_EQ(pole[l * l + l + m], 0);
        EXPECT_EQ(pole[l * l + l - m], 0);
      }
  }
}

TEST(DcshLiteral, TurnsOddSinesOverAtTheSeamAndLosesTheSignOfOddCosines) {
  const double y = 0.6, z = 0.8, step = 1e-7;
  double before[49], after[49], at[49], exact[49], mirrored[49];
  EvaluateLiteral({-step, y, z}, before);
  EvaluateLiteral({step, y, z}, after);
  EvaluateLiteral({0, y, z}, at);
  EvaluateLiteral({-0.48, y, 0.64}, mirrored);
  EvaluateBasis<6>(
      Vec3<double>{-0.48, y, 0.64}, BasisConstants(Basis::kDcshLiteral), exact);  // unfolded
  double largest = 0;
  for (int l = 1; l <= 6; ++l)
    for (int m = 1; m <= l; ++m) {
      const int sine = l * l + l - m, cosine = l * l + l + m;
      const double jump = after[sine] - before[sine];
      EXPECT_NEAR(jump, m % 2 ? 2 * at[sine] : 0, 1e-5) << l << ' ' << m;
      EXPECT_NEAR(after[cosine] - before[cosine], 0, 1e-5) << l << ' ' << m;
      EXPECT_NEAR(at[sine], after[sine], 1e-5);
      EXPECT_NEAR(mirrored[cosine], (m % 2 ? -1 : 1) * exact[cosine], 1e-12) << l << ' ' << m;
      largest = std::max(largest, std::abs(jump));
    }
  EXPECT_GT(largest, 1);  // of functions whose mean square is 1 / (4 pi)
}

TEST(DcshLiteral, FoldVjp) {
  const auto f = [](const auto& x) {
    using T = typename std::decay_t<decltype(x)>::value_type;
    const Vec3<T> folded = Fold(Vec3<T>{x[0], x[1], x[2]});
    return std::vector<T>{folded.x, folded.y, folded.z};
  };
  const auto vjp = [](const std::vector<double>& x, const std::vector<double>& d) {
    const auto d_x = FoldVjp(Vec3<double>{x[0], x[1], x[2]}, Vec3<double>{d[0], d[1], d[2]});
    return std::vector<double>{d_x.x, d_x.y, d_x.z};
  };
  for (unsigned seed = 1; seed < 9; ++seed) ExpectVjpMatchesDual(f, vjp, RandomVector(3, seed));
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
  for (const Basis basis : {Basis::kDcsh, Basis::kSh, Basis::kDcshReleased}) {
    CheckColorVjp<0>(basis);
    CheckColorVjp<1>(basis);
    CheckColorVjp<3>(basis);
    CheckColorVjp<4>(basis);
    CheckColorVjp<6>(basis);
  }
}

}  // namespace
}  // namespace cosplat::math
