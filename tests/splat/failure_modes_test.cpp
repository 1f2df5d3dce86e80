// How splatting is known to fail, and where each way is tested:
//
//   Jacobian blow-up               FailureModes.GrazingSplatsAwayFromThePrincipalPoint here;
//                                  Pinhole.ClampBoundsTheFootprintNearTheCameraPlane,
//                                  Rasterizer.GrazingAndHugeSplatsStayFinite
//   degenerate covariance          FailureModes.DegenerateCovariances; Gaussian.DegenerateInputs-
//                                  StayFinite
//   alpha towards 1                Rasterizer.ThousandOpaqueSplatsInOnePlace;
//                                  Blend.CappedAlphaHasNoGeometryGradient
//   forward/backward stop          FailureModes.GradientsAroundTheStop
//   NaN in SSIM                    Loss.DegenerateImagesAreFinite
//   direction at the centre        FailureModes.SplatsAtTheCamera; Vec.NormalizeVjpAndZero
//   needles, giants                FailureModes.TrainingMakesFewNeedles;
//                                  Trainer.TheRegulariserPullsNeedlesAlone;
//                                  Density.TransparentOversizedAndBrokenOnesGo
//   non-determinism                FailureModes.EqualDepthsGoByIndex; Trainer.BitsDependOnThe-
//                                  SeedAlone; Rasterizer.BitsDoNotDependOnThreads
//   integer overflow               FailureModes.TooManyInstancesAreRefusedBeforeTheyAreStored
//   project/emit drift             FailureModes.EveryPlaceOfTheListsIsWritten
//   nothing to draw                Rasterizer.NothingToDrawGivesTheBackground;
//                                  Trainer.PruningEverythingIsAnError; Density.NothingThere
//   out of memory                  Density.TheHardCapKeepsTheStrongest,
//                                  Trainer.TheHardCapHoldsInEveryStep; integer overflow, above
//   NaN inputs                     FailureModes.ValuesAtTheThresholds;
//                                  Rasterizer.NanGaussiansAreNotDrawn; Trainer.ABrokenGaussian-
//                                  IsRemovedAndTheRestTrains; Adam.BrokenGradientsCount...;
//                                  DensityStatistics.StayFinite; InitializeFromPoints.BadPoints...
//   disappearing when small        Rasterizer.AnAntialiasedGaussianKeepsItsSumAtAnyDistance
//
// There is no sort per pixel against popping.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splat/base/error.h"
#include "splat/config.h"
#include "splat/math/blend.h"
#include "splat/render/cpu/launch.h"
#include "splat/render/rasterizer.h"
#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"

namespace cosplat {
namespace {

using namespace test;

// Looks along +z from the origin.
Camera Straight(int side) {
  Camera c;
  c.width = c.height = side;
  c.fx = c.fy = float(side);
  c.cx = c.cy = 0.5f * float(side);
  return c;
}

Gaussians Blobs(size_t n, float depth, float scale) {
  Gaussians g;
  g.degree = 1;
  g.Resize(n);
  for (size_t i = 0; i < n; ++i) {
    g.at(kPosition, i)[2] = depth;
    g.at(kRotation, i)[0] = 1;
    g.at(kOpacityLogit, i)[0] = 1;
    for (int k = 0; k < 3; ++k) g.at(kScaleLog, i)[k] = std::log(scale);
    for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = 0.1f;
  }
  return g;
}

struct Rendering {
  RenderedImage image;
  Gaussians gradients;
  size_t visible = 0;
};

float Weight(size_t i) { return 0.6f + 0.4f * std::sin(0.7f * float(i)); }

Rendering ForwardBackward(const Gaussians& g, const Camera& camera) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  Rendering r;
  rasterizer->Forward(ViewOf(g), g.basis, camera, {{0.2f, 0.4f, 0.6f}, g.degree}, r.image, *tape);
  Buffer<float> d(r.image.color.size()), screen;
  for (size_t i = 0; i < d.size(); ++i) d[i] = Weight(i);
  r.gradients = g.ZerosLike();
  rasterizer->Backward(ViewOf(g), r.image, d, *tape, GradientViewOf(r.gradients, screen));
  r.visible = tape->counts()->visible;
  return r;
}

void ExpectFinite(const Rendering& r) {
  for (const float v : r.image.color) ASSERT_TRUE(std::isfinite(v));
  for (int a = 0; a < kAttributeCount; ++a)
    for (const float v : r.gradients.values[a]) ASSERT_TRUE(std::isfinite(v)) << "attribute " << a;
}

TEST(FailureModes, GrazingSplatsAwayFromThePrincipalPoint) {
  Camera camera = Straight(64);
  camera.cx = 0.1f * 64;
  for (const float depth : {std::nextafter(kNearPlane, 1.0f), 0.02f, 1.0f})
    for (const float degrees : {-89.0f, -60.0f, 60.0f, 89.0f})
      for (const float scale : {1e-3f, 0.1f, 10.0f}) {
        Gaussians g = Blobs(1, depth, scale);
        g.at(kPosition, 0)[0] = depth * std::tan(degrees * float(M_PI) / 180);
        ExpectFinite(ForwardBackward(g, camera));
      }
}

TEST(FailureModes, DegenerateCovariances) {
  for (const float x : {-1e30f, -46.0f, 0.0f, 46.0f, 1e30f})  // 1e-20, 1, 1e20 and beyond floats
    for (const float y : {-46.0f, -3.0f, 46.0f})
      for (const float norm : {0.0f, 1e-20f, 1.0f, 1e18f}) {
        Gaussians g = Blobs(1, 2, 0.1f);
        g.at(kScaleLog, 0)[0] = x;
        g.at(kScaleLog, 0)[1] = y;
        for (int k = 0; k < 4; ++k) g.at(kRotation, 0)[k] = norm * 0.5f;
        ExpectFinite(ForwardBackward(g, Straight(32)));
      }
}

TEST(FailureModes, SplatsAtTheCamera) {
  Gaussians g = Blobs(3, 0, 0.5f);
  g.at(kPosition, 1)[2] = kNearPlane;
  g.at(kPosition, 2)[2] = std::nextafter(kNearPlane, 1.0f);
  const Rendering r = ForwardBackward(g, Straight(32));
  ExpectFinite(r);
  EXPECT_EQ(r.visible, 1u);  // beyond the near plane alone
}

TEST(FailureModes, GradientsAroundTheStop) {
  // Alpha is 0.92 to 0.93 everywhere: three splats leave 4e-4 of the light, the fourth brings it
  // below the limit and is the last; two more lie behind.
  Gaussians g = Blobs(6, 3, 10);
  for (size_t i = 0; i < 6; ++i) {
    g.at(kPosition, i)[2] += 0.01f * float(i);
    g.at(kOpacityLogit, i)[0] = std::log(0.93f / 0.07f);
    for (int k = 0; k < 3; ++k) g.at(kColorDc, i)[k] = 0.5f * float(int(i) - k);
  }
  const Camera camera = Straight(16);
  const auto loss = [&] {
    const Rendering r = ForwardBackward(g, camera);
    double sum = 0;
    for (size_t i = 0; i < r.image.color.size(); ++i) sum += double(r.image.color[i]) * Weight(i);
    return sum;
  };
  const Rendering r = ForwardBackward(g, camera);
  ExpectFinite(r);
  for (const Attribute a : {kColorDc, kOpacityLogit})
    for (size_t k = 0; k < g.values[a].size(); ++k) {
      const float value = g.values[a][k], h = 0.02f;
      g.values[a][k] = value + h;
      const double up = loss();
      g.values[a][k] = value - h;
      const double numeric = (up - loss()) / (2 * double(h));
      g.values[a][k] = value;
      // Sums of 768 float pixels over 0.04.
      EXPECT_NEAR(r.gradients.values[a][k], numeric, 2e-3 + 1e-3 * std::abs(numeric))
          << a << ' ' << k;
      if (a == kColorDc && k / 3 >= 4) {
        EXPECT_EQ(r.gradients.values[a][k], 0);
      } else if (a == kColorDc && k / 3 == 3 && g.at(kColorDc, 3)[k % 3] > -1.5f) {
        EXPECT_GT(r.gradients.values[a][k], 1e-3);  // the last one counts
      }
    }
}

TEST(FailureModes, EqualDepthsGoByIndex) {
  Gaussians g = Blobs(2, 3, 1);
  for (size_t i = 0; i < 2; ++i) g.at(kOpacityLogit, i)[0] = 8;
  g.at(kColorDc, 0)[0] = g.at(kColorDc, 1)[1] = 1.7f;
  g.at(kColorDc, 0)[1] = g.at(kColorDc, 1)[0] = -1.7f;
  std::fill(g.values[kColorRest].begin(), g.values[kColorRest].end(), 0.0f);
  const size_t middle = 8 * 16 + 8, plane = 256;
  const RenderedImage first = Render(g, Straight(16));
  EXPECT_GT(first.color[middle], 0.9f);
  EXPECT_LT(first.color[plane + middle], 0.1f);
  g.Gather({1, 0});
  const RenderedImage second = Render(g, Straight(16));
  EXPECT_LT(second.color[middle], 0.1f);
  EXPECT_GT(second.color[plane + middle], 0.9f);
}

TEST(FailureModes, ValuesAtTheThresholds) {
  // One unit in the last place on both sides of each limit, and on it.
  const auto around = [](float x) {
    return std::vector<float>{std::nextafter(x, -INFINITY), x, std::nextafter(x, INFINITY)};
  };
  Gaussians base = Blobs(2, 2, 0.2f);
  const auto check = [&](Attribute a, int component, float limit) {
    for (const float value : around(limit)) {
      Gaussians g = base;
      g.at(a, 0)[component] = value;
      ExpectFinite(ForwardBackward(g, Straight(24)));
    }
  };
  check(kOpacityLogit, 0, -std::log(254.0f));        // alpha 1/255
  check(kOpacityLogit, 0, std::log(0.99f / 0.01f));  // and 0.99
  check(kOpacityLogit, 0, std::log(0.01f / 0.99f));  // the reset's
  check(kPosition, 2, kNearPlane);
  check(kRotation, 0, std::sqrt(kMinQuaternionNorm2));
  check(kColorDc, 0, -0.5f / 0.28209479f);  // colour 0
  check(kScaleLog, 0, -std::numeric_limits<float>::max());
  check(kScaleLog, 0, std::numeric_limits<float>::max());
}

ProjectedSplat WholeImageSplat(float size) {
  ProjectedSplat s{};
  s.x = s.y = 0.5f * size;
  s.power_xx = s.power_yy = -1e-12f;
  s.opacity = 0.5f;
  s.reject_below = math::RejectBelow(s.opacity);
  s.half_x = s.half_y = 1e6f;
  s.depth = 1;
  return s;
}

TEST(FailureModes, TooManyInstancesAreRefusedBeforeTheyAreStored) {
  // 1024^2 tiles under 2,048 splats: 2^31 pairs, 16 GiB of them. Then as many as 32 bits would see
  // as none.
  for (const size_t count : {2048, 4096}) {
    const std::vector<ProjectedSplat> splats(count, WholeImageSplat(16384));
    TileLists lists;
    ExpectError([&] { lists.Build(splats, std::vector<float>(count, 1.0f), 16384, 16384); },
                {"rasterizer", std::to_string(count * 1024 * 1024), "2^31"});
    // The same lists serve afterwards.
    const std::vector<ProjectedSplat> few(3, WholeImageSplat(64));
    lists.Build(few, std::vector<float>(3, 1.0f), 64, 64);
    EXPECT_EQ(lists.entries.size(), 3u * 16);
  }
}

TEST(FailureModes, WhatIsAllButTransparentIsNotDrawn) {
  // Logits that other programs write for an opacity of 0.
  for (const float logit : {-30.0f, -100.0f, -179.0f, -355.0f, -1000.0f, -INFINITY}) {
    Gaussians g = RandomGaussians(20, 1, Basis::kDcsh, 3);
    for (size_t i = 0; i < g.size(); ++i) {
      g.at(kPosition, i)[2] += 2;
      *g.at(kOpacityLogit, i) = logit;
    }
    const auto rasterizer = MakeCpuRasterizer();
    const auto tape = rasterizer->MakeTape();
    RenderedImage image;
    rasterizer->Forward(ViewOf(g), g.basis, Straight(32), {{0, 0, 0}, 1}, image, *tape);
    EXPECT_EQ(tape->counts()->visible, 0u) << logit;
  }
}

struct Projected {
  Buffer<ProjectedSplat> splats;
  Buffer<float> radii;
};
Projected Project(size_t count, uint64_t seed, int side) {
  Gaussians g = RandomGaussians(count, 1, Basis::kDcsh, seed);
  for (size_t i = 0; i < count; ++i) g.at(kPosition, i)[2] += 2;
  Projected p{Buffer<ProjectedSplat>(count), Buffer<float>(count)};
  LaunchProject(
      ViewOf(g), ViewOfCamera(Straight(side), g.basis, 0), p.splats.data(), p.radii.data());
  return p;
}

// Every pixel that takes a splat has it in its tile's list.
void ExpectListsHoldWhatPixelsTake(const TileLists& lists, const Projected& projected, int side) {
  for (int tile = 0; tile < lists.tiles_x * lists.tiles_y; ++tile) {
    std::vector<bool> listed(projected.radii.size());
    for (uint32_t e = lists.tile_begin[tile]; e < lists.tile_begin[tile + 1]; ++e)
      listed[lists.entries[e].gaussian] = true;
    const int x0 = tile % lists.tiles_x * kTileSize, y0 = tile / lists.tiles_x * kTileSize;
    for (int y = y0; y < std::min(side, y0 + kTileSize); ++y)
      for (int x = x0; x < std::min(side, x0 + kTileSize); ++x)
        for (size_t i = 0; i < listed.size(); ++i) {
          const ProjectedSplat& s = projected.splats[i];
          if (listed[i] || !(projected.radii[i] > 0)) continue;
          const double dx = x + 0.5 - s.x, dy = y + 0.5 - s.y;
          const double power = s.power_xx * dx * dx + s.power_xy * dx * dy + s.power_yy * dy * dy;
          ASSERT_LT(power, s.reject_below + 1e-4) << "splat " << i << " at " << x << ' ' << y;
        }
  }
}

TEST(FailureModes, EveryPlaceOfTheListsIsWritten) {
  const int side = 75;
  TileLists lists;
  for (const auto& [count, seed] : {std::pair<size_t, int>{9000, 1}, {300, 2}, {5000, 3}}) {
    const Projected projected = Project(count, seed, side);
    const Buffer<ProjectedSplat>& splats = projected.splats;
    // What an earlier step left must not show: poison all there is.
    lists.entries.assign(lists.entries.capacity(), {0xdeadbeef, 0xdeadbeef});
    for (Buffer<uint32_t>* b : {&lists.order, &lists.record_begin, &lists.tile_begin})
      b->assign(b->capacity(), 0xdeadbeef);
    lists.Build(splats, projected.radii, side, side);

    const size_t total = lists.entries.size();
    ASSERT_EQ(lists.tile_begin.size(), 26u);
    EXPECT_EQ(lists.tile_begin.front(), 0u);
    EXPECT_EQ(lists.tile_begin.back(), total);
    EXPECT_EQ(lists.record_begin.back(), total);
    std::vector<uint32_t> rank(count, 0xffffffff), seen(total);
    for (size_t k = 0; k < lists.order.size(); ++k) rank.at(lists.order[k]) = uint32_t(k);
    for (size_t t = 0; t < 25; ++t) {
      ASSERT_LE(lists.tile_begin[t], lists.tile_begin[t + 1]);
      for (uint32_t e = lists.tile_begin[t]; e < lists.tile_begin[t + 1]; ++e) {
        const TileEntry& entry = lists.entries[e];
        ASSERT_LT(entry.gaussian, count);
        ASSERT_LT(entry.record, total);
        ++seen[entry.record];
        const uint32_t k = rank[entry.gaussian];
        ASSERT_LT(k, lists.order.size());
        EXPECT_GE(entry.record, lists.record_begin[k]);  // among its own
        EXPECT_LT(entry.record, lists.record_begin[k + 1]);
        if (e > lists.tile_begin[t]) {
          EXPECT_LT(rank[lists.entries[e - 1].gaussian], k);
        }
      }
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1u), std::ptrdiff_t(total));
    if (count == 300) ExpectListsHoldWhatPixelsTake(lists, projected, side);
  }
}

TEST(FailureModes, TrainingMakesFewNeedles) {
  SceneSubject subject(TargetImages(TrueScene(1), Ring(6, 2.2f)), 1);
  const Gaussians g = Train(ShortRun(400, 1), subject, FirstGaussians(250, 1), 400).gaussians;
  std::vector<float> ratios;
  for (size_t i = 0; i < g.size(); ++i) {
    const float* s = g.at(kScaleLog, i);
    const auto [low, high] = std::minmax_element(s, s + 3);
    ratios.push_back(std::exp(*high - *low));
    EXPECT_LT(std::exp(*high), 1);  // the scene's size; measured 0.28
  }
  std::sort(ratios.begin(), ratios.end());
  EXPECT_LT(ratios[ratios.size() / 2], 4);          // measured 1.7
  EXPECT_LT(ratios[ratios.size() * 99 / 100], 20);  // measured 4.7
}

}  // namespace
}  // namespace cosplat
