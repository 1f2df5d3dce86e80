// Every formula of splat/math: known values, properties, and its VJP against dual numbers.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "splat/math/adam.h"
#include "splat/math/blend.h"
#include "splat/math/exposure.h"
#include "splat/math/gaussian.h"
#include "splat/math/pinhole.h"
#include "splat/math/ssim.h"
#include "tests/support/gradient_check.h"

namespace cosplat::math {
namespace {

using test::Dual;
using test::ExpectVjpMatchesDual;
using test::RandomVector;

template <class T>
Quat<T> Q(const std::vector<T>& x, size_t i) {
  return {x[i], x[i + 1], x[i + 2], x[i + 3]};
}
template <class T>
Vec3<T> V(const std::vector<T>& x, size_t i) {
  return {x[i], x[i + 1], x[i + 2]};
}

TEST(Exposure, Vjp) {
  const auto f = [](const auto& x) {
    const auto y = Exposed(x.data(), V(x, kExposureNumbers));
    return std::decay_t<decltype(x)>{y.x, y.y, y.z};
  };
  const auto vjp = [](const std::vector<double>& x, const std::vector<double>& d) {
    std::vector<double> d_x(kExposureNumbers, 0.0);
    const Vec3<double> d_color =
        ExposedVjp(x.data(), V(x, kExposureNumbers), {d[0], d[1], d[2]}, d_x.data());
    d_x.insert(d_x.end(), {d_color.x, d_color.y, d_color.z});
    return d_x;
  };
  ExpectVjpMatchesDual(f, vjp, RandomVector(kExposureNumbers + 3, 1));
}

TEST(Quat, RotationOfKnownAngle) {
  const double s = std::sqrt(0.5);
  const Vec3<double> v = RotationOf(Quat<double>{s, 0, 0, s}) * Vec3<double>{1, 0, 0};
  EXPECT_NEAR(v.x, 0, 1e-15);  // 90 degrees about z takes x to y
  EXPECT_NEAR(v.y, 1, 1e-15);
}

TEST(Quat, ProductIsComposition) {
  const auto x = RandomVector(11, 3);
  const Quat<double> a = Normalize(Q(x, 0)), b = Normalize(Q(x, 4));
  const Vec3<double> one = RotationOf(Multiply(a, b)) * V(x, 8);
  const Vec3<double> two = RotationOf(a) * (RotationOf(b) * V(x, 8));
  EXPECT_NEAR(one.x, two.x, 1e-14);
  EXPECT_NEAR(one.y, two.y, 1e-14);
  EXPECT_NEAR(one.z, two.z, 1e-14);
}

TEST(Quat, RotationVjp) {
  const auto f = [](const auto& x) {
    const auto r = RotationOf(Normalize(Q(x, 0)));
    return std::decay_t<decltype(x)>(r.m, r.m + 9);
  };
  const auto vjp = [](const std::vector<double>& x, const std::vector<double>& d) {
    Mat3<double> dm;
    for (int i = 0; i < 9; ++i) dm.m[i] = d[i];
    const Quat<double> q = NormalizeVjp(Q(x, 0), RotationOfVjp(Normalize(Q(x, 0)), dm));
    return std::vector<double>{q.w, q.x, q.y, q.z};
  };
  for (unsigned seed = 1; seed < 6; ++seed) ExpectVjpMatchesDual(f, vjp, RandomVector(4, seed));
}

TEST(Quat, MultiplyVjp) {
  const auto f = [](const auto& x) {
    const auto q = Multiply(Q(x, 0), Q(x, 4));
    return std::decay_t<decltype(x)>{q.w, q.x, q.y, q.z};
  };
  const auto vjp = [](const std::vector<double>& x, const std::vector<double>& d) {
    Quat<double> a{0, 0, 0, 0}, b{0, 0, 0, 0};
    MultiplyVjp(Q(x, 0), Q(x, 4), Q(d, 0), a, b);
    return std::vector<double>{a.w, a.x, a.y, a.z, b.w, b.x, b.y, b.z};
  };
  ExpectVjpMatchesDual(f, vjp, RandomVector(8, 1));
}

TEST(Vec, NormalizeVjpAndZero) {
  const auto f = [](const auto& x) {
    const auto u = Normalize(V(x, 0));
    return std::decay_t<decltype(x)>{u.x, u.y, u.z};
  };
  const auto vjp = [](const std::vector<double>& x, const std::vector<double>& d) {
    const Vec3<double> v = NormalizeVjp(V(x, 0), V(d, 0));
    return std::vector<double>{v.x, v.y, v.z};
  };
  ExpectVjpMatchesDual(f, vjp, RandomVector(3, 1));
  const Vec3<double> zero = NormalizeVjp(Vec3<double>{0, 0, 0}, Vec3<double>{1, 2, 3});
  EXPECT_EQ(zero.x, 0);  // a splat at the camera's centre: no direction, no gradient
}

TEST(Gaussian, CovarianceOfAxisAlignedScale) {
  const Sym3<double> c = Covariance(Quat<double>{2, 0, 0, 0}, Vec3<double>{1, 2, 3});
  EXPECT_NEAR(c.xx, 1, 1e-14);
  EXPECT_NEAR(c.yy, 4, 1e-14);
  EXPECT_NEAR(c.zz, 9, 1e-14);
  EXPECT_NEAR(c.xy, 0, 1e-14);
}

TEST(Gaussian, CovarianceVjp) {
  const auto f = [](const auto& x) {
    const auto c = Covariance(Q(x, 0), V(x, 4));
    return std::decay_t<decltype(x)>{c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
  };
  const auto vjp = [](const std::vector<double>& x, const std::vector<double>& d) {
    Quat<double> q;
    Vec3<double> s;
    CovarianceVjp(Q(x, 0), V(x, 4), Sym3<double>{d[0], d[1], d[2], d[3], d[4], d[5]}, q, s);
    return std::vector<double>{q.w, q.x, q.y, q.z, s.x, s.y, s.z};
  };
  for (unsigned seed = 1; seed < 6; ++seed) ExpectVjpMatchesDual(f, vjp, RandomVector(7, seed));
}

TEST(Gaussian, DegenerateInputsStayFinite) {
  for (const double scale : {0.0, 1e-20, 1e20}) {
    Quat<double> q;
    Vec3<double> s;
    CovarianceVjp(Quat<double>{0, 0, 0, 0},
                  Vec3<double>{scale, scale, scale},
                  Sym3<double>{1, 1, 1, 1, 1, 1},
                  q,
                  s);
    EXPECT_TRUE(std::isfinite(q.w + q.x + q.y + q.z + s.x + s.y + s.z));
  }
}

template <class T>
Pinhole<T> TestCamera() {
  Pinhole<T> c;
  const Mat3<double> r = RotationOf(Normalize(Quat<double>{0.9, 0.1, -0.2, 0.3}));
  for (int i = 0; i < 9; ++i) c.rotation.m[i] = T(r.m[i]);
  c.translation = {T(0.1), T(-0.2), T(4.0)};
  c.fx = T(120);
  c.fy = T(110);
  c.cx = T(10);  // far off the middle: the clamp is about the principal point
  c.cy = T(55);
  c.width = T(100);
  c.height = T(90);
  c.near_plane = T(0.01);
  return c;
}

TEST(Pinhole, ProjectionVjp) {
  const auto f = [](const auto& x) {
    using T = typename std::decay_t<decltype(x)>::value_type;
    const auto c = TestCamera<T>();
    const auto p = ToCamera(c, V(x, 0));
    const auto xy = ProjectPoint(c, p);
    const auto cov =
        ProjectCovariance(c, p, Sym3<T>{x[3], x[4], x[5], x[6], x[7], x[8]}, T(kBlurVariance));
    const auto conic = Conic(cov);
    return std::decay_t<decltype(x)>{xy.x, xy.y, conic.xx, conic.xy, conic.yy};
  };
  const auto vjp = [](const std::vector<double>& x, const std::vector<double>& d) {
    const auto c = TestCamera<double>();
    const auto p = ToCamera(c, V(x, 0));
    const Sym3<double> cov3{x[3], x[4], x[5], x[6], x[7], x[8]};
    const auto conic = Conic(ProjectCovariance(c, p, cov3, double(kBlurVariance)));
    const auto d_cov = ConicVjp(conic, Sym2<double>{d[2], d[3], d[4]});
    Vec3<double> d_p = ProjectPointVjp(c, p, Vec2<double>{d[0], d[1]});
    Sym3<double> d3;
    ProjectCovarianceVjp(c, p, cov3, d_cov, d3, d_p);
    const auto d_x = TransposeTimes(c.rotation, d_p);
    return std::vector<double>{d_x.x, d_x.y, d_x.z, d3.xx, d3.xy, d3.xz, d3.yy, d3.yz, d3.zz};
  };
  // On the image, and beyond the clamp on each side.
  for (const std::array<double, 3>& p :
       {std::array<double, 3>{0.1, 0.2, 0.3}, {9, 1, 0}, {-9, 0, 1}, {0, 9, 0.5}, {1, -9, 0}})
    ExpectVjpMatchesDual(f, vjp, {p[0], p[1], p[2], 0.5, 0.1, -0.05, 0.4, 0.07, 0.3});
}

TEST(Pinhole, LowPassShareVjp) {
  const auto f = [](const auto& x) {
    using T = typename std::decay_t<decltype(x)>::value_type;
    return std::decay_t<decltype(x)>{LowPassShare(Sym2<T>{x[0], x[1], x[2]}, T(0.1))};
  };
  const auto vjp = [](const std::vector<double>& x, const std::vector<double>& d) {
    const auto d_c = LowPassShareVjp(Sym2<double>{x[0], x[1], x[2]}, 0.1, d[0]);
    return std::vector<double>{d_c.xx, d_c.xy, d_c.yy};
  };
  // Round, slanted, far below a pixel, and below the floor: constant there.
  for (const std::array<double, 3>& c : {std::array<double, 3>{1, 0, 1},
                                         {2, 0.7, 0.5},
                                         {1e-3, 2e-4, 1e-3},
                                         {1e-5, 0, 1e-5},
                                         {0, 0, 0}})
    ExpectVjpMatchesDual(f, vjp, {c[0], c[1], c[2]});
  EXPECT_DOUBLE_EQ(LowPassShare(Sym2<double>{0.3, 0, 0.3}, 0.1), 0.75);
  EXPECT_DOUBLE_EQ(LowPassShare(Sym2<double>{0, 0, 0}, 0.1), std::sqrt(double(kMinLowPassRatio)));
  const auto low = LowPass(Sym2<double>{2, 0.7, 0.5}, 0.1);
  EXPECT_EQ(low.xx, 2.1);
  EXPECT_EQ(low.xy, 0.7);
  EXPECT_EQ(low.yy, 0.6);
}

TEST(Pinhole, SamplingRateIsPixelsPerUnitWhereTheViewSees) {
  const auto c = TestCamera<double>();
  EXPECT_DOUBLE_EQ(SamplingRate(c, Vec3<double>{0, 0, 4}), 30);  // the larger focal length
  EXPECT_EQ(SamplingRate(c, Vec3<double>{0, 0, -4}), 0);
  EXPECT_EQ(SamplingRate(c, Vec3<double>{0, 0, 0}), 0);
  // At x = 100 + 15 % of the width, the image's edge with its margin.
  const double edge = (115 - c.cx) / c.fx;
  EXPECT_DOUBLE_EQ(SamplingRate(c, Vec3<double>{0.99 * edge, 0, 1}), 120);
  EXPECT_EQ(SamplingRate(c, Vec3<double>{1.01 * edge, 0, 1}), 0);
}

TEST(Gaussian, SmoothScaleVjp) {
  const auto f = [](const auto& x) {
    using T = typename std::decay_t<decltype(x)>::value_type;
    const auto s = SmoothScale(Vec3<T>{Exp(x[0]), Exp(x[1]), Exp(x[2])}, T(0.04));
    return std::decay_t<decltype(x)>{s.scale.x, s.scale.y, s.scale.z, s.share};
  };
  const auto vjp = [](const std::vector<double>& x, const std::vector<double>& d) {
    const Vec3<double> s{std::exp(x[0]), std::exp(x[1]), std::exp(x[2])};
    const auto d_log =
        SmoothScaleVjp(s, 0.04, SmoothScale(s, 0.04), Vec3<double>{d[0], d[1], d[2]}, d[3]);
    return std::vector<double>{d_log.x, d_log.y, d_log.z};
  };
  for (const double size : {0.0, -1.5, -6.0, -40.0})
    ExpectVjpMatchesDual(f, vjp, {size, size + 0.7, size - 0.4});
}

TEST(Gaussian, SmoothingKeepsTheIntegral) {
  const Vec3<double> s{0.3, 0.1, 0.02};
  const auto smoothed = SmoothScale(s, 0.01);
  EXPECT_NEAR(smoothed.scale.x * smoothed.scale.x, 0.1, 1e-15);
  EXPECT_NEAR(smoothed.share * smoothed.scale.x * smoothed.scale.y * smoothed.scale.z,
              s.x * s.y * s.z,
              1e-18);
  EXPECT_EQ(SmoothScale(s, 0.0).share, 1);
}

TEST(Pinhole, ClampBoundsTheFootprintNearTheCameraPlane) {
  const auto c = TestCamera<double>();
  const Vec3<double> grazing{50, 0, 0.011};  // about 89.99 degrees off the axis
  const auto cov =
      ProjectCovariance(c, grazing, Sym3<double>{1e-4, 0, 0, 1e-4, 0, 1e-4}, double(kBlurVariance));
  EXPECT_TRUE(std::isfinite(cov.xx));
  EXPECT_LT(std::sqrt(cov.xx), 1e3 * 120 * 1e-2 / 0.011);
  Sym3<double> d3;
  Vec3<double> d_p{0, 0, 0};
  ProjectCovarianceVjp(
      c, grazing, Sym3<double>{1e-4, 0, 0, 1e-4, 0, 1e-4}, Sym2<double>{1, 1, 1}, d3, d_p);
  EXPECT_TRUE(std::isfinite(d_p.x + d_p.y + d_p.z));
  EXPECT_EQ(d_p.x, 0);  // clamped: sideways motion does not change the Jacobian
}

// A pixel under three splats over a background, as a function of every parameter of every splat.
template <class T>
std::vector<T> BlendPixel(const std::vector<T>& x) {
  BlendState<T> state{T(1), {T(0), T(0), T(0)}};
  for (size_t i = 0; i < x.size(); i += 9) {
    const PowerForm<T> form{x[i + 2], x[i + 3], x[i + 4]};
    const T power = PowerAt(form, T(0.5) - x[i], T(0.3) - x[i + 1]);
    const bool accept = Accepts(power, RejectBelow(x[i + 5]), state.transmittance);
    const T falloff = accept ? Exp(power) : T(0);
    BlendBehind(AlphaOf(x[i + 5], falloff), V(x, i + 6), state);
  }
  const T bg[3] = {T(0.2), T(0.7), T(0.4)};
  return {state.color.x + state.transmittance * bg[0],
          state.color.y + state.transmittance * bg[1],
          state.color.z + state.transmittance * bg[2]};
}

std::vector<double> BlendPixelVjp(const std::vector<double>& x, const std::vector<double>& d) {
  const auto pixel = BlendPixel(x);
  BlendVjpState<double> state{1, d[0] * pixel[0] + d[1] * pixel[1] + d[2] * pixel[2]};
  std::vector<double> d_x(x.size());
  for (size_t i = 0; i < x.size(); i += 9) {
    const PowerForm<double> form{x[i + 2], x[i + 3], x[i + 4]};
    const double dx = 0.5 - x[i], dy = 0.3 - x[i + 1];
    const double power = PowerAt(form, dx, dy);
    const bool accept = Accepts(power, RejectBelow(x[i + 5]), state.transmittance);
    const double falloff = accept ? Exp(power) : 0;
    const auto r = BlendBehindVjp(AlphaOf(x[i + 5], falloff), V(x, i + 6), V(d, 0), state);
    const double d_product = AlphaOfVjp(x[i + 5], falloff, r.d_alpha) * falloff;
    // About another point, then moved back.
    PowerMoments<double> m{0, 0, 0, 0, 0, 0};
    Accumulate(d_product, dx - 3, dy + 2, m);
    m = MomentsMovedBy(m, 3.0, -2.0);
    const auto shape = ShapeVjp(form, x[i + 5], m);
    const std::vector<double> g{shape.x,
                                shape.y,
                                shape.power_xx,
                                shape.power_xy,
                                shape.power_yy,
                                shape.opacity,
                                r.weight * d[0],
                                r.weight * d[1],
                                r.weight * d[2]};
    std::copy(g.begin(), g.end(), d_x.begin() + i);
  }
  return d_x;
}

TEST(Blend, PixelVjp) {
  const std::vector<double> x{0.2, 0.1, -0.3, 0.1, -0.2, 0.6, 0.9, 0.1, 0.3,   // in front
                              0.9, 0.4, -0.2, 0.0, -0.4, 0.8, 0.1, 0.8, 0.2,   //
                              0.4, 0.2, -0.1, 0.1, -0.1, 0.5, 0.3, 0.3, 0.9};  // behind
  ExpectVjpMatchesDual([](const auto& v) { return BlendPixel(v); }, BlendPixelVjp, x);
}

TEST(Blend, ExponentAboutAnotherPoint) {
  const PowerForm<double> form{-0.3, 0.2, -0.7};
  const PowerExpansion<double> at = ExpandAt(form, 2.5, -1.5);
  for (const double x : {0.0, 1.0, 3.0})
    for (const double y : {0.0, 2.0, 3.0})
      EXPECT_NEAR(
          PowerNear(at, x, y, PowerAt(form, x, y)), PowerAt(form, 2.5 + x, -1.5 + y), 1e-12);
}

TEST(Blend, LargestExponentInARectangle) {
  // Against the largest of a fine grid, which is at most its spacing's square lower.
  for (const PowerForm<double>& form :
       {PowerForm<double>{-0.3, 0.2, -0.7}, {-0.05, -0.18, -0.2}, {-1, 0, -1e-3}})
    for (const double x : {-9.0, -2.0, 0.5, 4.0})
      for (const double y : {-7.0, -1.0, 0.0, 3.0}) {
        double largest = -1e9;
        for (int i = 0; i <= 300; ++i)
          for (int j = 0; j <= 300; ++j)
            largest = std::max(largest, PowerAt(form, x + 0.01 * i, y + 0.01 * j));
        const double found = LargestPowerIn(form, RidgesOf(form), x, x + 3, y, y + 3);
        EXPECT_GE(found, largest - 1e-12);
        EXPECT_LE(found, largest + 2e-4);
      }
}

TEST(Blend, CappedAlphaHasNoGeometryGradient) {
  const std::vector<double> x{0.5, 0.3, -0.3, 0.1, -0.2, 0.999, 0.9, 0.1, 0.3};
  ExpectVjpMatchesDual([](const auto& v) { return BlendPixel(v); }, BlendPixelVjp, x);
  EXPECT_EQ(BlendPixelVjp(x, {1, 1, 1})[5], 0);
}

TEST(Blend, ManyOpaqueSplatsStayFinite) {
  std::vector<double> x;
  for (int i = 0; i < 1000; ++i)
    for (const double v : {0.5, 0.3, -0.3, 0.0, -0.3, 0.9999, 0.5, 0.5, 0.5}) x.push_back(v);
  for (const double d : BlendPixelVjp(x, {1, -1, 1})) EXPECT_TRUE(std::isfinite(d));
}

TEST(Ssim, EqualImagesGiveOneAndVjpMatches) {
  // u = x + y and v = x - y of two images; those of equal ones are 2x and 0.
  EXPECT_NEAR(Ssim(SsimMoments<double>{0.8, 0, 0.8, 0}), 1, 1e-12);
  // Means 0.4 and 0.5, E[x^2] = 0.25, E[y^2] = 0.3, E[xy] = 0.22, in eq. 13 as it is written.
  const double c1 = kSsimC1, c2 = kSsimC2, var_x = 0.25 - 0.16, var_y = 0.3 - 0.25;
  EXPECT_NEAR(Ssim(SsimMoments<double>{0.9, -0.1, 0.55 + 0.44, 0.55 - 0.44}),
              (2 * 0.4 * 0.5 + c1) * (2 * (0.22 - 0.4 * 0.5) + c2) /
                  ((0.16 + 0.25 + c1) * (var_x + var_y + c2)),
              1e-12);
  // The VJP's first is along both means at once, as a change of x moves them.
  const auto f = [](const auto& x) {
    using T = typename std::decay_t<decltype(x)>::value_type;
    return std::vector<T>{Ssim(SsimMoments<T>{T(0.9) + x[0], T(-0.1) + x[0], x[1], x[2]})};
  };
  const auto vjp = [](const std::vector<double>& x, const std::vector<double>& d) {
    const auto p = SsimVjp(SsimMoments<double>{0.9 + x[0], -0.1 + x[0], x[1], x[2]});
    return std::vector<double>{p.mean * d[0], p.uu * d[0], p.vv * d[0]};
  };
  ExpectVjpMatchesDual(f, vjp, {0.02, 0.99, 0.11});
  ExpectVjpMatchesDual(f, vjp, {0.02, 0.7, 0.11});    // one variance clamped at zero
  ExpectVjpMatchesDual(f, vjp, {0.02, 0.99, 0.001});  // the other
}

TEST(Adam, FirstStepMovesByTheRate) {
  // m_hat / sqrt(v_hat) = sign(g) at t = 1, whatever the size of g.
  const double rate = 0.01, c1 = 1 - 0.9, c2 = std::sqrt(1 - 0.999);
  const AdamStep step{0.9f, 0.999f, float(rate * c2 / c1), float(1e-15 * c2)};
  double value = 1, m = 0, v = 0;
  AdamUpdate(step, 123.0, value, m, v);
  EXPECT_NEAR(value, 1 - rate, 1e-7);
}

}  // namespace
}  // namespace cosplat::math
