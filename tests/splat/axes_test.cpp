#include <gtest/gtest.h>

#include <algorithm>

#include "splat/basis_constants.h"
#include "splat/io/splat_primitive.h"
#include "splat/math/dcsh.h"
#include "tests/support/random_gaussians.h"

namespace cosplat {
namespace {

using math::Vec3;
using test::RandomGaussians;

TEST(GltfTurn, FlipsTheKnownCoefficients) {
  const std::vector<int> flipped{1, 2, 4, 7, 9, 11, 12, 14};
  for (int k = 0; k < CoefficientCount(3); ++k) {
    const bool is_flipped = std::find(flipped.begin(), flipped.end(), k) != flipped.end();
    EXPECT_EQ(GltfTurnSign(k), is_flipped ? -1 : 1) << "coefficient " << k;
  }
}

TEST(GltfTurn, ColorsFollowTheDirectionInBothBasesToDegreeFour) {
  for (Basis basis : {Basis::kDcsh, Basis::kSh}) {
    const Gaussians before = RandomGaussians(50, 4, basis, 1);
    Gaussians after = before;
    TurnToGltfAxes(after);
    Rng rng{2};
    for (size_t i = 0; i < before.size(); ++i) {
      const auto u = math::Normalize(Vec3<float>{rng.Normal(), rng.Normal(), rng.Normal()});
      const auto a = math::EvaluateColor<4>(
          u, BasisConstants(basis), before.at(kColorDc, i), before.at(kColorRest, i));
      const auto b = math::EvaluateColor<4>(Vec3<float>{u.x, -u.y, -u.z},
                                            BasisConstants(basis),
                                            after.at(kColorDc, i),
                                            after.at(kColorRest, i));
      // The same products with signs exchanged, added in the same order: measured 0.
      EXPECT_NEAR(a.x, b.x, 1e-6);
      EXPECT_NEAR(a.y, b.y, 1e-6);
      EXPECT_NEAR(a.z, b.z, 1e-6);
    }
  }
}

TEST(GltfTurn, ACameraTurnedAlongSeesTheSameImage) {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = camera.fy = 60;
  camera.cx = 30;
  camera.cy = 25;
  camera.translation = {0.05f, -0.02f, 3};
  Camera turned = camera;  // cam_from_gltf = cam_from_world * diag(1, -1, -1)
  for (int i = 0; i < 9; ++i)
    if (i % 3 != 0) turned.rotation[i] = -turned.rotation[i];
  const Gaussians before = RandomGaussians(200, 3, Basis::kDcsh, 3);
  Gaussians after = before;
  TurnToGltfAxes(after);
  const auto a = test::Image(before, camera), b = test::Image(after, turned);
  EXPECT_LT(test::LargestDifference(a, b), 1e-5);
  EXPECT_GT(test::LargestDifference(a, test::Image(before, turned)), 0.1);
}

TEST(GltfTurn, TwiceIsNothing) {
  const Gaussians before = RandomGaussians(5, 3, Basis::kSh, 4);
  Gaussians after = before;
  TurnToGltfAxes(after);
  TurnToGltfAxes(after);
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < before.values[a].size(); ++i)
      EXPECT_EQ(after.values[a][i], (a == kRotation ? -1 : 1) * before.values[a][i]);
}

}  // namespace
}  // namespace cosplat
