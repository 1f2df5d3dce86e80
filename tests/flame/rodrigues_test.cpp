// flame/math: Rodrigues' formula and the kinematic tree, against known values and dual numbers.
#include "flame/math/rodrigues.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "flame/math/kinematics.h"
#include "tests/support/gradient_check.h"

namespace cosplat::test {
namespace {

using math::Mat3;
using math::Vec3;

template <class T>
Vec3<T> At(const std::vector<T>& x, size_t i) {
  return {x[i], x[i + 1], x[i + 2]};
}

struct RodriguesFunctor {
  template <class T>
  std::vector<T> operator()(const std::vector<T>& x) const {
    const Mat3<T> r = flame_math::Rodrigues(At(x, 0));
    return {r.m, r.m + 9};
  }
};

std::vector<double> RodriguesVjpOf(const std::vector<double>& x, const std::vector<double>& d) {
  Mat3<double> d_r;
  std::copy(d.begin(), d.end(), d_r.m);
  const auto d_w = flame_math::RodriguesVjp(At(x, 0), d_r);
  return {d_w.x, d_w.y, d_w.z};
}

TEST(Rodrigues, QuarterTurnAboutZ) {
  const auto r = flame_math::Rodrigues<double>({0, 0, std::numbers::pi / 2});
  const double expected[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(r.m[i], expected[i], 1e-15);
}

TEST(Rodrigues, ZeroAngleIsIdentityWithSkewDerivative) {
  const auto r = flame_math::Rodrigues<double>({0, 0, 0});
  for (int i = 0; i < 9; ++i) EXPECT_EQ(r.m[i], i % 4 == 0 ? 1 : 0);
  const auto d = flame_math::RodriguesVjp<double>({0, 0, 0}, {{0, -1, 0, 1, 0, 0, 0, 0, 5}});
  EXPECT_EQ((std::array{d.x, d.y, d.z}), (std::array<double, 3>{0, 0, 2}));
}

TEST(Rodrigues, OrthonormalAtEveryAngle) {
  for (double scale :
       {0.0, 1e-300, 1e-160, 1e-12, 1e-4, 0.3, 0.577, 0.578, 1.0, 1.8138, 3.0, 50.0}) {
    const auto r = flame_math::Rodrigues<double>({scale, -scale, scale});
    const auto product = r * math::Transpose(r);
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(product.m[i], i % 4 == 0, 2e-14) << scale;
  }
}

TEST(Rodrigues, SeriesMeetsTrigonometryAtOneRadian) {
  for (double s : {0.999999999, 1.000000001}) {
    const auto c = flame_math::RodriguesCoefficientsOf(s);
    const double t = std::sqrt(s);
    EXPECT_NEAR(c.a, std::sin(t) / t, 1e-15);
    EXPECT_NEAR(c.b, (1 - std::cos(t)) / s, 1e-15);
    EXPECT_NEAR(c.d_a, (std::cos(t) - std::sin(t) / t) / (2 * s), 1e-14);
    EXPECT_NEAR(c.d_b, (std::sin(t) / (2 * t) - (1 - std::cos(t)) / s) / s, 1e-14);
  }
}

TEST(Rodrigues, VjpMatchesDual) {
  for (double scale : {0.0, 1e-9, 1e-3, 0.5, 1.0, 3.0, 20.0})
    ExpectVjpMatchesDual(RodriguesFunctor(), RodriguesVjpOf, RandomVector(3, 7, scale));
}

constexpr std::array<int, 5> kParents = {-1, 0, 1, 1, 1};

template <class T>
void Unpack(const std::vector<T>& x,
            std::array<Mat3<T>, 5>& local,
            std::array<Vec3<T>, 5>& joints) {
  for (int j = 0; j < 5; ++j) {
    std::copy_n(x.begin() + 12 * j, 9, local[j].m);
    joints[j] = At(x, 12 * j + 9);
  }
}

struct PoseJointsFunctor {
  template <class T>
  std::vector<T> operator()(const std::vector<T>& x) const {
    std::array<Mat3<T>, 5> local;
    std::array<Vec3<T>, 5> joints;
    Unpack(x, local, joints);
    const auto out = flame_math::PoseJoints(local, joints, kParents);
    std::vector<T> y;
    for (const auto& r : out.rotation) y.insert(y.end(), r.m, r.m + 9);
    for (const auto& t : out.translation) y.insert(y.end(), {t.x, t.y, t.z});
    return y;
  }
};

std::vector<double> PoseJointsVjpOf(const std::vector<double>& x, const std::vector<double>& d) {
  std::array<Mat3<double>, 5> local, d_local{};
  std::array<Vec3<double>, 5> joints, d_joints{};
  Unpack(x, local, joints);
  flame_math::JointTransforms<double, 5> d_out;
  for (int j = 0; j < 5; ++j) {
    std::copy_n(d.begin() + 9 * j, 9, d_out.rotation[j].m);
    d_out.translation[j] = At(d, 45 + 3 * j);
  }
  flame_math::PoseJointsVjp(local,
                            joints,
                            kParents,
                            flame_math::PoseJoints(local, joints, kParents),
                            d_out,
                            d_local,
                            d_joints);
  std::vector<double> d_x;
  for (int j = 0; j < 5; ++j) {
    d_x.insert(d_x.end(), d_local[j].m, d_local[j].m + 9);
    d_x.insert(d_x.end(), &d_joints[j].x, &d_joints[j].x + 3);
  }
  return d_x;
}

TEST(Kinematics, VjpMatchesDual) {
  ExpectVjpMatchesDual(PoseJointsFunctor(), PoseJointsVjpOf, RandomVector(60, 3));
}

TEST(Kinematics, EveryJointStaysOnItsParent) {
  std::array<Mat3<double>, 5> local;
  std::array<Vec3<double>, 5> joints;
  const auto x = RandomVector(30, 4);
  for (int j = 0; j < 5; ++j) {
    local[j] = flame_math::Rodrigues(At(x, 3 * j));
    joints[j] = At(x, 15 + 3 * j);
  }
  const auto out = flame_math::PoseJoints(local, joints, kParents);
  const auto apply = [&](int j, const Vec3<double>& p) {
    return out.rotation[j] * p + out.translation[j];
  };
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(apply(0, joints[0])[i], joints[0][i], 1e-14);
  for (int j = 1; j < 5; ++j)
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(apply(j, joints[j])[i], apply(kParents[j], joints[j])[i], 1e-13);
}

}  // namespace
}  // namespace cosplat::test
