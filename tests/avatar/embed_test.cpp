#include "avatar/math/embed.h"

#include <gtest/gtest.h>

#include <cmath>

#include "avatar/math/correct.h"
#include "tests/support/gradient_check.h"

namespace cosplat {
namespace {

using math::Mat3;
using math::Quat;
using math::Three;
using math::Vec3;
using test::Dual;
using test::ExpectVjpMatchesDual;
using test::RandomVector;

template <class T>
Vec3<T> V(const std::vector<T>& x, size_t i) {
  return {x[i], x[i + 1], x[i + 2]};
}
template <class T>
Quat<T> Q(const std::vector<T>& x, size_t i) {
  return {x[i], x[i + 1], x[i + 2], x[i + 3]};
}
template <class T>
Mat3<T> M(const std::vector<T>& x, size_t i) {
  Mat3<T> m;
  for (int k = 0; k < 9; ++k) m.m[k] = x[i + k];
  return m;
}
template <class T>
void Put(std::vector<T>& y, const Vec3<T>& v) {
  y.insert(y.end(), {v.x, v.y, v.z});
}
template <class T>
void Put(std::vector<T>& y, const Quat<T>& q) {
  y.insert(y.end(), {q.w, q.x, q.y, q.z});
}

Quat<double> RandomUnit(unsigned seed) { return math::Normalize(Q(RandomVector(4, seed), 0)); }

template <class T>
Mat3<T> Constant(const Mat3<double>& m) {
  Mat3<T> c;
  for (int k = 0; k < 9; ++k) c.m[k] = T(m.m[k]);
  return c;
}

TEST(FrameFormula, LengthAndAreaVector) {
  const auto area = math::AreaVector<double>({0, 0, 0}, {2, 0, 0}, {0, 3, 0});
  EXPECT_DOUBLE_EQ(area.z, 3);
  EXPECT_DOUBLE_EQ(math::Length(area), 3);
  ExpectVjpMatchesDual(
      [](const auto& x) {
        const auto a = math::AreaVector(V(x, 0), V(x, 3), V(x, 6));
        auto y = x;
        y.clear();
        Put(y, a);
        y.push_back(math::Length(a));
        return y;
      },
      [](const auto& x, const auto& d) {
        const auto a = math::AreaVector(V(x, 0), V(x, 3), V(x, 6));
        const auto d_a = V(d, 0) + math::LengthVjp(a, d[3]);
        Vec3<double> d_v[3] = {};
        math::AreaVectorVjp(V(x, 0), V(x, 3), V(x, 6), d_a, d_v[0], d_v[1], d_v[2]);
        std::vector<double> d_x;
        for (const auto& v : d_v) Put(d_x, v);
        return d_x;
      },
      RandomVector(9, 2));
}

TEST(FrameFormula, FaceFrameIsARotationAndItsVjpHolds) {
  const auto x = RandomVector(9, 3);
  const auto frame = math::FaceFrame(V(x, 0), V(x, 3), V(x, 6));
  const auto identity = frame * math::Transpose(frame);
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(identity.m[k], k % 4 == 0, 1e-14);
  const auto column = [&](int c) { return Vec3<double>{frame(0, c), frame(1, c), frame(2, c)}; };
  EXPECT_NEAR(math::Dot(math::Cross(column(0), column(1)), column(2)), 1, 1e-14);
  ExpectVjpMatchesDual(
      [](const auto& x) {
        const auto m = math::FaceFrame(V(x, 0), V(x, 3), V(x, 6));
        auto y = x;
        y.assign(m.m, m.m + 9);
        return y;
      },
      [](const auto& x, const auto& d) {
        Vec3<double> d_v[3] = {};
        math::FaceFrameVjp(V(x, 0), V(x, 3), V(x, 6), M(d, 0), d_v[0], d_v[1], d_v[2]);
        std::vector<double> d_x;
        for (const auto& v : d_v) Put(d_x, v);
        return d_x;
      },
      x);
}

// Every branch: half turns about x, y, z make w zero and one of the others 1.
TEST(FrameFormula, QuatOfRotationInvertsRotationOf) {
  std::vector<Quat<double>> cases{{1, 0, 0, 0},
                                  {0, 1, 0, 0},
                                  {0, 0, 1, 0},
                                  {0, 0, 0, 1},
                                  {.5, .5, .5, .5},
                                  {-.5, .5, -.5, .5},
                                  {0, .6, .8, 0}};
  for (unsigned seed = 0; seed < 200; ++seed) cases.push_back(RandomUnit(seed));
  for (const auto& q : cases) {
    const auto r = math::QuatOfRotation(math::RotationOf(q));
    EXPECT_NEAR(std::abs(math::Dot(q, r)), 1, 1e-14);
  }
}

TEST(FrameFormula, QuatOfRotationVjpInEveryBranch) {
  const std::vector<Quat<double>> cases{
      {.9, .1, -.2, .3}, {.1, .9, -.2, .3}, {.2, .1, .9, -.3}, {.1, -.2, .3, .9}};
  for (const auto& q : cases) {
    const auto m = math::RotationOf(math::Normalize(q));
    ExpectVjpMatchesDual(
        [](const auto& x) {
          auto y = x;
          y.clear();
          Put(y, math::QuatOfRotation(M(x, 0)));
          return y;
        },
        [](const auto& x, const auto& d) {
          const auto d_m = math::QuatOfRotationVjp(M(x, 0), Q(d, 0));
          return std::vector<double>(d_m.m, d_m.m + 9);
        },
        std::vector<double>(m.m, m.m + 9));
  }
}

TEST(FrameFormula, FaceRotationCarriesTheCanonicalTriangle) {
  const auto x = RandomVector(9, 5);
  const auto q = RandomUnit(6);
  const auto r = math::RotationOf(q);
  const auto frame = math::FaceFrame(V(x, 0), V(x, 3), V(x, 6));
  const auto found = math::FaceRotation(r * V(x, 0), r * V(x, 3), r * V(x, 6), frame);
  EXPECT_NEAR(std::abs(math::Dot(found, q)), 1, 1e-14);
}

TEST(FrameFormula, FaceRotationVjp) {
  for (unsigned seed = 10; seed < 20; ++seed) {
    const auto canonical = math::RotationOf(RandomUnit(seed));
    ExpectVjpMatchesDual(
        [&](const auto& x) {
          using T = std::decay_t<decltype(x[0])>;
          auto y = x;
          y.clear();
          Put(y, math::FaceRotation(V(x, 0), V(x, 3), V(x, 6), Constant<T>(canonical)));
          return y;
        },
        [&](const auto& x, const auto& d) {
          Vec3<double> d_v[3] = {};
          math::FaceRotationVjp(
              V(x, 0), V(x, 3), V(x, 6), canonical, Q(d, 0), d_v[0], d_v[1], d_v[2]);
          std::vector<double> d_x;
          for (const auto& v : d_v) Put(d_x, v);
          return d_x;
        },
        RandomVector(9, seed));
  }
}

TEST(FrameFormula, CollapsedTriangleIsFinite) {
  const Vec3<double> p{1, 2, 3}, q{2, 4, 6};
  for (const auto& [a, b, c] : {std::array{p, p, p}, std::array{p, q, p}, std::array{p, p, q}}) {
    const auto frame = math::RotationOf(RandomUnit(1));
    const auto r = math::FaceRotation(a, b, c, frame);
    EXPECT_TRUE(std::isfinite(r.w + r.x + r.y + r.z));
    Vec3<double> d[3] = {};
    math::FaceRotationVjp(a, b, c, frame, {1, 1, 1, 1}, d[0], d[1], d[2]);
    math::AreaVectorVjp(a, b, c, math::LengthVjp(math::AreaVector(a, b, c), 1.0), d[0], d[1], d[2]);
    for (const auto& v : d) EXPECT_TRUE(std::isfinite(v.x + v.y + v.z));
  }
}

TEST(EmbedFormula, PositivePart) {
  const auto inside = math::PositivePart<double>({{.2, .3, .5}});
  EXPECT_NEAR(inside[0], .2, 1e-15);
  EXPECT_NEAR(inside[2], .5, 1e-15);
  const auto outside = math::PositivePart<double>({{1.5, -.5, 0}});
  EXPECT_EQ(outside[0], 1);
  EXPECT_EQ(outside[1], 0);
  for (const auto& b : {std::vector<double>{.2, .3, .5}, {1.2, .3, -.5}, {-.4, 1.9, -.5}})
    ExpectVjpMatchesDual(
        [](const auto& x) {
          using T = std::decay_t<decltype(x[0])>;
          const auto w = math::PositivePart(Three<T>{{x[0], x[1], x[2]}});
          return std::vector<T>(w.c, w.c + 3);
        },
        [](const auto& x, const auto& d) {
          const auto d_b =
              math::PositivePartVjp<double>({{x[0], x[1], x[2]}}, {{d[0], d[1], d[2]}});
          return std::vector<double>(d_b.c, d_b.c + 3);
        },
        b);
}

// The sign of a stored quaternion has no meaning: the blend must not depend on it.
TEST(EmbedFormula, BlendIgnoresTheSignsOfItsQuaternions) {
  const Three<double> w{{.2, .5, .3}};
  Three<Quat<double>> q{{{1, .1, 0, 0}, {1, 0, .2, 0}, {1, 0, 0, .3}}};
  for (auto& x : q.c) x = math::Normalize(x);
  const auto expected = math::BlendRotations(q, w);
  for (int mask = 0; mask < 8; ++mask) {
    auto flipped = q;
    for (int i = 0; i < 3; ++i)
      if (mask >> i & 1) flipped[i] = flipped[i] * -1.0;
    EXPECT_NEAR(std::abs(math::Dot(math::BlendRotations(flipped, w), expected)), 1, 1e-14);
  }
}

TEST(EmbedFormula, BlendNeverCancels) {
  for (unsigned seed = 0; seed < 500; ++seed) {
    const Three<Quat<double>> q{
        {RandomUnit(3 * seed), RandomUnit(3 * seed + 1), RandomUnit(3 * seed + 2)}};
    const auto r = RandomVector(3, seed);
    const auto w = math::PositivePart<double>({{r[0], r[1], 1 - r[0] - r[1]}});
    const auto sum = math::SignedSum(q, math::BlendSigns(q, w), w);
    EXPECT_GE(math::Dot(sum, sum), 1.0 / 9 - 1e-12);
  }
}

TEST(EmbedFormula, BlendRotationsVjp) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    auto x = RandomVector(15, seed);
    for (int i = 12; i < 15; ++i) x[i] = std::abs(x[i]);
    ExpectVjpMatchesDual(
        [](const auto& x) {
          using T = std::decay_t<decltype(x[0])>;
          std::vector<T> y;
          Put(y, math::BlendRotations<T>({{Q(x, 0), Q(x, 4), Q(x, 8)}}, {{x[12], x[13], x[14]}}));
          return y;
        },
        [](const auto& x, const auto& d) {
          Three<Quat<double>> d_q{};
          Three<double> d_w{};
          math::BlendRotationsVjp<double>(
              {{Q(x, 0), Q(x, 4), Q(x, 8)}}, {{x[12], x[13], x[14]}}, Q(d, 0), d_q, d_w);
          std::vector<double> d_x;
          for (const auto& q : d_q.c) Put(d_x, q);
          d_x.insert(d_x.end(), d_w.c, d_w.c + 3);
          return d_x;
        },
        x);
  }
}

// The inverse scale blow-up of the released SplattingAvatar: there, half the area made it larger.
TEST(EmbedFormula, ScaleFollowsTheRootOfTheArea) {
  double last = 0;
  for (double area : {.25, .5, 1., 2., 4.}) {
    const double factor = std::exp(math::ScaleShift(area * 1e-5, 1e-5));
    EXPECT_NEAR(factor, std::sqrt(area), 1e-12);
    EXPECT_GT(factor, last);
    last = factor;
  }
  EXPECT_NEAR(std::exp(math::ScaleShift(1e9, 1.)), 4, 1e-12);
  EXPECT_NEAR(std::exp(math::ScaleShift(0., 1.)), .25, 1e-12);
  EXPECT_EQ(math::ScaleShift(1., 0.), 0);
}

TEST(EmbedFormula, ScaleShiftVjp) {
  // Free, clamped below, clamped above, collapsed, canonically collapsed.
  for (const auto& x :
       {std::vector<double>{2e-5, 1e-5}, {1e-7, 1e-5}, {1., 1e-5}, {0., 1e-5}, {1e-5, 0.}})
    ExpectVjpMatchesDual(
        [](const auto& x) {
          using T = std::decay_t<decltype(x[0])>;
          return std::vector<T>{math::ScaleShift(x[0], x[1])};
        },
        [](const auto& x, const auto& d) {
          std::vector<double> d_x(2);
          math::ScaleShiftVjp(x[0], x[1], d[0], d_x[0], d_x[1]);
          return d_x;
        },
        x);
}

// Layout of x: per vertex position 3, normal 3, rotation 4, area 1; then offset 3, rotation 4,
// scale 3.
constexpr int kVertexWidth = 11;
const std::array<double, 2> kBase{.3, .25};

template <class T>
Three<math::SurfaceVertex<T>> VerticesOf(const std::vector<T>& x) {
  Three<math::SurfaceVertex<T>> v;
  for (int i = 0; i < 3; ++i) {
    const size_t at = i * kVertexWidth;
    v[i] = {V(x, at), V(x, at + 3), Q(x, at + 6), x[at + 10]};
  }
  return v;
}
template <class T>
math::EmbeddedGaussian<T> LocalOf(const std::vector<T>& x) {
  const size_t at = 3 * kVertexWidth;
  return {T(kBase[0]), T(kBase[1]), V(x, at), Q(x, at + 3), V(x, at + 7)};
}

struct EmbedFunction {
  template <class T>
  std::vector<T> operator()(const std::vector<T>& x) const {
    const auto p = math::Embed(VerticesOf(x), {{T(.9), T(1.1), T(1.3)}}, LocalOf(x));
    std::vector<T> y;
    Put(y, p.position);
    Put(y, p.rotation);
    Put(y, p.scale_log);
    Put(y, p.frame);
    return y;
  }
};
void PutVertices(std::vector<double>& y, const Three<math::SurfaceVertex<double>>& vertices) {
  for (const auto& v : vertices.c) {
    Put(y, v.position);
    Put(y, v.normal);
    Put(y, v.rotation);
    y.push_back(v.area);
  }
}
std::vector<double> EmbedVjpFunction(const std::vector<double>& x, const std::vector<double>& d) {
  math::EmbeddedGaussian<double> d_g;
  Three<math::SurfaceVertex<double>> d_v{};
  math::EmbedVjp(VerticesOf(x),
                 {{.9, 1.1, 1.3}},
                 LocalOf(x),
                 {V(d, 0), Q(d, 3), V(d, 7), Q(d, 10)},
                 d_g,
                 &d_v);
  std::vector<double> d_x;
  PutVertices(d_x, d_v);
  Put(d_x, d_g.offset);
  Put(d_x, d_g.rotation);
  Put(d_x, d_g.scale_log);
  return d_x;
}

TEST(EmbedFormula, EmbedVjpInsideAndOutsideTheTriangle) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    auto x = RandomVector(3 * kVertexWidth + 10, seed);
    for (int i = 0; i < 3; ++i) x[i * kVertexWidth + 10] = .5 + std::abs(x[i * kVertexWidth + 10]);
    for (int k = 0; k < 2; ++k) x[3 * kVertexWidth + k] *= seed % 2 ? .05 : .8;
    ExpectVjpMatchesDual(EmbedFunction(), EmbedVjpFunction, x);
  }
}

// The same after a sum of weighted bases, x's last numbers, has corrected the Gaussian.
constexpr size_t kFirstCorrection = 3 * kVertexWidth + 10;
template <class T>
math::Correction<T> CorrectionIn(const std::vector<T>& x) {
  T c[math::kCorrectionWidth];
  for (int k = 0; k < math::kCorrectionWidth; ++k) c[k] = x[kFirstCorrection + size_t(k)];
  return math::CorrectionOf(c);
}
struct CorrectedFunction {
  template <class T>
  std::vector<T> operator()(const std::vector<T>& x) const {
    const math::Correction<T> c = CorrectionIn(x);
    const auto p = math::EmbedCorrected(VerticesOf(x), {{T(.9), T(1.1), T(1.3)}}, LocalOf(x), c);
    std::vector<T> y;
    Put(y, p.position);
    Put(y, p.rotation);
    Put(y, p.scale_log);
    Put(y, p.frame);
    y.push_back(c.opacity_logit);
    Put(y, c.color_dc);
    return y;
  }
};
std::vector<double> CorrectedVjp(const std::vector<double>& x, const std::vector<double>& d) {
  math::EmbeddedGaussian<double> d_g;
  math::Correction<double> d_c;
  Three<math::SurfaceVertex<double>> d_v{};
  math::EmbedCorrectedVjp(VerticesOf(x),
                          {{.9, 1.1, 1.3}},
                          LocalOf(x),
                          CorrectionIn(x),
                          {V(d, 0), Q(d, 3), V(d, 7), Q(d, 10)},
                          d_g,
                          d_c,
                          &d_v);
  d_c.opacity_logit = d[14];
  d_c.color_dc = V(d, 15);
  std::vector<double> d_x;
  PutVertices(d_x, d_v);
  Put(d_x, d_g.offset);
  Put(d_x, d_g.rotation);
  Put(d_x, d_g.scale_log);
  double d_numbers[math::kCorrectionWidth];
  math::CorrectionOfVjp(d_c, d_numbers);
  d_x.insert(d_x.end(), d_numbers, d_numbers + math::kCorrectionWidth);
  return d_x;
}

TEST(EmbedFormula, EmbedCorrectedVjpMatchesDual) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    auto x = RandomVector(kFirstCorrection + math::kCorrectionWidth, seed);
    for (int i = 0; i < 3; ++i) x[i * kVertexWidth + 10] = .5 + std::abs(x[i * kVertexWidth + 10]);
    for (int k = 0; k < 2; ++k) x[3 * kVertexWidth + k] *= seed % 2 ? .05 : .8;
    ExpectVjpMatchesDual(CorrectedFunction(), CorrectedVjp, x);
  }
}

TEST(EmbedFormula, NormalsThatCancelLeaveThePointOnTheTriangle) {
  Three<math::SurfaceVertex<double>> v{};
  v[0] = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0, 0}, 1};
  v[1] = {{1, 0, 0}, {0, 0, -1}, {1, 0, 0, 0}, 1};
  v[2] = {{0, 1, 0}, {0, 0, 0}, {1, 0, 0, 0}, 1};
  const math::EmbeddedGaussian<double> g{.25, .25, {0, 0, 5}, {1, 0, 0, 0}, {0, 0, 0}};
  const auto p = math::Embed(v, {{1, 1, 1}}, g);
  EXPECT_EQ(p.position.z, 0);
  EXPECT_NEAR(p.position.x, .25, 1e-15);
  math::EmbeddedGaussian<double> d;
  math::EmbedVjp(v, {{1, 1, 1}}, g, {{1, 1, 1}, {}, {}, {}}, d, &v);
  EXPECT_TRUE(std::isfinite(d.offset.x + d.offset.y + d.offset.z));
}

}  // namespace
}  // namespace cosplat
