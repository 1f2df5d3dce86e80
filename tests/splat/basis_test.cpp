// The colour bases beyond their formulas: names, conversion, through files, through the renderer.
#include "splat/basis.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "splat/io/ply.h"
#include "splat/io/splat_file.h"
#include "splat/render/cpu/launch.h"
#include "splat/render/rasterizer.h"
#include "tests/support/expect_error.h"
#include "tests/support/looking_at.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::kHarmonicBases;
using test::RandomGaussians;

TEST(Basis, Names) {
  for (size_t i = 0; i < kBasisNames.size(); ++i)
    EXPECT_EQ(BasisFromString(ToString(Basis(i))), Basis(i));
  EXPECT_EQ(ToString(Basis::kDcshLiteral), "dcsh-literal");
  ExpectError([] { BasisFromString("fourier", "run.json", "basis"); },
              {"run.json: basis", "fourier", "dcsh, sh, dcsh-released, dcsh-literal"});
}

TEST(Basis, ConversionThereAndBackIsTheSame) {
  for (const Basis from : kHarmonicBases)
    for (const Basis to : kHarmonicBases) {
      const Gaussians before = RandomGaussians(20, 4, from, 1);
      Gaussians after = before;
      ConvertBasis(after, to);
      EXPECT_EQ(after.basis, to);
      ConvertBasis(after, from);
      for (int a = 0; a < kAttributeCount; ++a)
        for (size_t i = 0; i < before.values[a].size(); ++i)
          EXPECT_NEAR(after.values[a][i], before.values[a][i], 1e-7);
    }
}

TEST(Basis, TheLiteralOneCannotBeConverted) {
  const test::TemporaryFolder folder;
  for (const Basis other : kHarmonicBases) {
    Gaussians literal = RandomGaussians(3, 1, Basis::kDcshLiteral, 1);
    Gaussians harmonic = RandomGaussians(3, 1, other, 1);
    const std::vector<std::string> said{"basis: dcsh-literal",
                                        "cannot be converted to spherical harmonics"};
    ExpectError([&] { ConvertBasis(literal, other); }, said);
    ExpectError([&] { ConvertBasis(harmonic, Basis::kDcshLiteral); }, said);
    ExpectError([&] { WriteSceneGlb(folder / "scene.glb", literal); }, said);
    EXPECT_EQ(literal.basis, Basis::kDcshLiteral);
    EXPECT_EQ(harmonic.basis, other);
    // A constant colour is one in every basis.
    Gaussians constant = RandomGaussians(3, 0, Basis::kDcshLiteral, 1);
    ConvertBasis(constant, other);
    EXPECT_EQ(constant.basis, other);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Basis, TheImageIsTheSameThroughAPly) {
  const test::TemporaryFolder folder;
  const Camera camera = test::LookingAt({0.3f, -0.2f, -3}, {0, 0, 0}, 64);
  for (const Basis basis : kHarmonicBases)
    for (int degree = 1; degree <= kMaxTrainedDegree; ++degree) {
      const Gaussians scene = RandomGaussians(150, degree, basis, 5 + degree);
      Gaussians sh = scene;
      ConvertBasis(sh, Basis::kSh);
      WritePly(folder / "scene.ply", sh);
      Gaussians read = ReadPly(folder / "scene.ply");
      const RenderedImage before = test::Image(scene, camera);
      // As others show it, and converted back. Measured: 2.4e-7.
      EXPECT_LT(test::LargestDifference(before, test::Image(read, camera)), 1e-5);
      ConvertBasis(read, basis);
      EXPECT_LT(test::LargestDifference(before, test::Image(read, camera)), 1e-5);
      // The coefficients do matter.
      read.basis = basis == Basis::kDcsh ? Basis::kSh : Basis::kDcsh;
      if (basis == Basis::kDcshReleased && degree == 1) continue;  // it is dcsh there
      EXPECT_GT(test::LargestDifference(before, test::Image(read, camera)), 1e-2);
    }
}

struct Projected {
  Buffer<ProjectedSplat> splats;
  Gaussians d;
};

// Colours seen from the origin along +z, and the gradients of a loss of theirs alone.
Projected ColorsOf(const Gaussians& g) {
  Camera camera;
  camera.width = camera.height = 64;
  camera.fx = camera.fy = 32;
  camera.cx = camera.cy = 32;
  const ViewParameters view = ViewOfCamera(camera, g.basis, g.degree);
  Projected p;
  p.splats.resize(g.size());
  Buffer<float> radii(g.size()), screen;
  LaunchProject(ViewOf(g), view, p.splats.data(), radii.data());
  for (const float radius : radii) EXPECT_GT(radius, 0);
  Buffer<SplatGradient> d_splats(g.size());
  Rng rng{8};
  for (SplatGradient& d : d_splats)
    d = {0, 0, 0, 0, 0, 0, rng.Normal(), rng.Normal(), rng.Normal()};
  p.d = g.ZerosLike();
  LaunchProjectVjp(
      ViewOf(g), view, p.splats.data(), radii.data(), d_splats.data(), GradientViewOf(p.d, screen));
  return p;
}

// Gaussians of the literal basis before a camera at the origin, all at x > 0.
Gaussians InFront(int degree) {
  Gaussians g = RandomGaussians(100, degree, Basis::kDcshLiteral, 3);
  for (size_t i = 0; i < g.size(); ++i) {
    float* p = g.at(kPosition, i);
    p[0] = 0.01f + std::abs(p[0]);
    p[2] += 4;
  }
  return g;
}

TEST(Basis, TheLiteralOneIsShForPositiveX) {
  for (int degree = 0; degree <= kMaxTrainedDegree; ++degree) {
    const Gaussians literal = InFront(degree);
    Gaussians sh = literal;
    sh.basis = Basis::kSh;
    const auto turn_odd_orders = [](Gaussians& g) {  // 3DGS's signs, (-1)^m
      for (size_t i = 0; i < g.size(); ++i)
        for (int l = 1; l <= g.degree; ++l)
          for (int m = -l; m <= l; ++m)
            for (int c = 0; c < 3; ++c)
              if (m % 2) g.at(kColorRest, i)[3 * (l * l + l + m - 1) + c] *= -1;
    };
    turn_odd_orders(sh);
    const Projected a = ColorsOf(literal);
    Projected b = ColorsOf(sh);
    turn_odd_orders(b.d);
    for (size_t i = 0; i < literal.size(); ++i) {
      EXPECT_EQ(a.splats[i].r, b.splats[i].r);
      EXPECT_EQ(a.splats[i].b, b.splats[i].b);
    }
    for (const int attribute : {kPosition, kColorDc, kColorRest})
      for (size_t i = 0; i < a.d.values[attribute].size(); ++i)
        EXPECT_EQ(a.d.values[attribute][i], b.d.values[attribute][i]) << attribute;
  }
}

TEST(Basis, TheLiteralOneShowsOppositeAzimuthsTheSame) {
  const Gaussians front = InFront(3);
  Gaussians back = front;
  for (size_t i = 0; i < back.size(); ++i)
    for (int k = 0; k < 2; ++k) back.at(kPosition, i)[k] *= -1;
  const Projected a = ColorsOf(front), b = ColorsOf(back);
  float largest = 0;
  for (size_t i = 0; i < front.size(); ++i) {
    EXPECT_EQ(a.splats[i].r, b.splats[i].r);
    EXPECT_EQ(a.splats[i].g, b.splats[i].g);
    const float *d = a.d.at(kPosition, i), *mirrored = b.d.at(kPosition, i);
    EXPECT_EQ(d[0], -mirrored[0]);
    EXPECT_EQ(d[1], -mirrored[1]);
    EXPECT_EQ(d[2], mirrored[2]);
    largest = std::max(largest, std::abs(d[0]));
  }
  EXPECT_GT(largest, 0.05f);
  EXPECT_EQ(a.d.values[kColorRest], b.d.values[kColorRest]);
}

}  // namespace
}  // namespace cosplat
