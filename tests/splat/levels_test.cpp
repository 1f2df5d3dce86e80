// Levels of detail: what stands for what, which of it is drawn, and its file.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "splat/base/files.h"
#include "splat/levels/frame_budget.h"
#include "splat/levels/level_renderer.h"
#include "splat/levels/levels_file.h"
#include "splat/levels/merge.h"
#include "splat/math/gaussian.h"
#include "splat/train/loss/loss.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

constexpr std::array<float, 3> kBackground{0.3f, 0.5f, 0.7f};

// Many small Gaussians, as in a large scene.
Gaussians Scene(size_t n = 20000) {
  Gaussians g = RandomGaussians(n, 1, Basis::kSh, 4);
  for (float& s : g.values[kScaleLog]) s -= 2;
  return g;
}

// At `distance` before the origin.
Camera From(float distance, int side = 96) {
  Camera c;
  c.width = c.height = side;
  c.fx = c.fy = float(side);
  c.cx = c.cy = 0.5f * float(side);
  c.translation = {0, 0, distance};
  return c;
}

RenderedImage Drawn(LevelRenderer& renderer, const Camera& camera, const LevelLimits& limits) {
  RenderedImage image;
  const int degree = renderer.levels().layout.degree;
  renderer.Draw(camera, {kBackground, degree}, limits, image);
  return image;
}

TEST(Levels, FinestOnesAreTheScene) {
  const Gaussians scene = Scene();
  LevelRenderer renderer(BuildLevels(scene));
  EXPECT_EQ(renderer.levels().size(), scene.size());
  for (const float distance : {3.0f, 0.2f}) {
    const RenderedImage image = Drawn(renderer, From(distance), {0});
    EXPECT_LT(LargestDifference(image, Image(scene, From(distance))), 2e-4f) << distance;
  }
  EXPECT_LT(renderer.drawn(), scene.size()) << "from within, not all is in the image";
}

TEST(Levels, OfEveryLayoutAndSizeShowTheScene) {
  for (const size_t n : {1, 2, 1023, 1024, 1025, 2048, 2049, 5000}) {
    Gaussians scene = RandomGaussians(n, int(n % 4), Basis::kDcsh, n);
    scene.antialiased = n % 2 == 1;
    const TemporaryFolder folder;
    WriteLevels(folder / "a", BuildLevels(scene));
    LevelRenderer renderer(OpenLevels(folder / "a"));
    EXPECT_EQ(renderer.levels().size(), n);
    for (const float distance : {3.0f, 0.2f})  // large ones, before the camera and about it
      EXPECT_LT(
          LargestDifference(Drawn(renderer, From(distance), {0}), Image(scene, From(distance))),
          2e-4f)
          << n << " " << distance;
    EXPECT_TRUE(std::isfinite(Drawn(renderer, From(3), {0, 1}).color[0]));
  }
}

// One that is large, far or both does not keep the others coarse, and its file can be read.
TEST(Levels, StrangeGaussiansDoNotHideTheOthers) {
  for (const float scale : {-60.0f, 3.0f, 20.0f, 39.0f, 100.0f, 400.0f})
    for (const float far : {0.0f, 1e10f, 1e18f, 1e25f, 3e38f}) {
      Gaussians scene = Scene(5000);
      std::fill_n(scene.at(kScaleLog, 17), 3, scale);
      scene.at(kPosition, 17)[2] = far;
      scene.at(kPosition, 99)[0] = -far;
      const TemporaryFolder folder;
      WriteLevels(folder / "a", BuildLevels(scene));
      LevelRenderer renderer(OpenLevels(folder / "a"));
      EXPECT_LT(LargestDifference(Drawn(renderer, From(3), {0}), Image(scene, From(3))), 2e-4f)
          << scale << " " << far;
    }
}

TEST(Levels, EachHasHalfTheGaussiansOfTheFinerOne) {
  const SceneLevels levels = BuildLevels(Scene(10001));
  std::vector<size_t> counts{0};
  for (size_t b = 0; b < levels.blocks.size(); ++b) {
    counts.back() += levels.blocks[b].count;
    const bool last = levels.blocks[b].count < kLevelBlock || b + 1 == levels.blocks.size();
    if (last && b + 1 < levels.blocks.size()) counts.push_back(0);
  }
  EXPECT_EQ(counts, (std::vector<size_t>{10001, 5001, 2501, 1251, 626}));
  EXPECT_EQ(levels.Coarsest().size(), 626u);
}

TEST(Levels, EveryBlockButTheLastHasOneParentWhichIsCoarserAndHoldsIt) {
  const SceneLevels levels = BuildLevels(Scene());
  std::vector<int> parents(levels.blocks.size());
  for (const LevelBlock& parent : levels.blocks)
    for (uint32_t c = parent.first_child; c < parent.first_child + parent.children; ++c) {
      ++parents[c];
      EXPECT_GE(parent.coarseness, levels.blocks[c].coarseness);
      for (size_t k = 0; k < 3; ++k) {
        EXPECT_LE(parent.min[k], levels.blocks[c].min[k]);
        EXPECT_GE(parent.max[k], levels.blocks[c].max[k]);
      }
    }
  EXPECT_EQ(parents.back(), 0);
  parents.pop_back();
  for (const int count : parents) EXPECT_EQ(count, 1);
}

// Its neighbours are of one surface and one colour, as in what was photographed.
TEST(Levels, CoarserThanAPixelIsCloseToAll) {
  Gaussians scene = Scene();
  for (size_t i = 0; i < scene.size(); ++i) {
    float* p = scene.at(kPosition, i);
    const float length = std::hypot(p[0], p[1], p[2]);
    for (int k = 0; k < 3; ++k) p[k] /= length;
    for (int k = 0; k < 3; ++k) scene.at(kColorDc, i)[k] = std::sin(6 * p[k]);
    *scene.at(kOpacityLogit, i) = 2;
  }
  LevelRenderer renderer(BuildLevels(scene));
  const Camera camera = From(4, 256);
  const RenderedImage all = Image(scene, camera);
  double before = 101;
  size_t drawn = scene.size() + 1;
  for (const float coarseness : {1.0f, 1.5f, 3.0f}) {
    const double psnr = Psnr(Drawn(renderer, camera, {coarseness}).color, all.color);
    EXPECT_LT(psnr, before);
    EXPECT_LT(renderer.drawn(), drawn);
    EXPECT_GT(psnr, 29) << coarseness;  // measured: 70, 41, 31
    before = psnr;
    drawn = renderer.drawn();
  }
}

TEST(Levels, NoMoreIsDrawnThanTheLimit) {
  LevelRenderer renderer(BuildLevels(Scene()));
  for (const size_t max : {15000, 5000, 2000}) {
    Drawn(renderer, From(2), {0, max});
    EXPECT_LE(renderer.drawn(), max);
    EXPECT_GT(renderer.drawn(), max / 2);
  }
  Drawn(renderer, From(2), {0, 1});
  EXPECT_LE(renderer.drawn(), kLevelBlock) << "something is drawn";
  EXPECT_GT(renderer.drawn(), 0u);
  Camera away = From(2);
  away.translation[2] = -1000;
  Drawn(renderer, away, {});
  EXPECT_EQ(renderer.drawn(), 0u) << "behind the camera";
}

TEST(Levels, ImagesDoNotDependOnThoseBefore) {
  const SceneLevels levels = BuildLevels(Scene());
  LevelRenderer moved(levels);
  for (const float distance : {9.0f, 0.1f, 5.0f, 0.5f, 30.0f, 2.0f})
    Drawn(moved, From(distance), {1, 12000});
  Drawn(moved, From(3), {1, 9000});
  const size_t copied = moved.copied();
  const RenderedImage again = Drawn(moved, From(3), {1, 9000});
  EXPECT_GT(copied, 0u);
  EXPECT_EQ(moved.copied(), 0u) << "all is there";
  LevelRenderer fresh(levels);
  EXPECT_LT(LargestDifference(again, Drawn(fresh, From(3), {1, 9000})), 1e-4f);
  EXPECT_EQ(fresh.drawn(), moved.drawn());
}

TEST(Levels, AreTheSameForAnyNumberOfThreads) {
  const auto bytes = [](size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const TemporaryFolder folder;
    WriteLevels(folder / "a", BuildLevels(Scene()));
    return ReadFile(folder / "a");
  };
  EXPECT_EQ(bytes(1), bytes(3));
}

TEST(Levels, LeaveOutWhatIsNotRendered) {
  Gaussians scene = Scene(3000);
  scene.at(kPosition, 7)[1] = NAN;
  scene.at(kColorRest, 2000)[3] = INFINITY;
  std::fill_n(scene.at(kRotation, 40), 4, 0.0f);
  *scene.at(kOpacityLogit, 41) = -9;
  const SceneLevels levels = BuildLevels(std::move(scene));
  EXPECT_EQ(levels.size(), 2996u);
  EXPECT_TRUE(BuildLevels(Gaussians{}).blocks.empty());
  LevelRenderer nothing(BuildLevels(Gaussians{}));
  EXPECT_EQ(Drawn(nothing, From(2), {}).color[0], kBackground[0]);
  Gaussians smoothed = Scene(10);
  smoothed.smoothing.assign(10, 0.1f);
  ExpectError([&] { BuildLevels(smoothed); }, {"smoothing"});
}

// Mean and covariance of a weighted pair, by their definition.
TEST(MergeTwo, KeepsMeanCovarianceAndCoverage) {
  Gaussians g = RandomGaussians(3, 1, Basis::kSh, 9);
  *g.at(kOpacityLogit, 0) = -1.5f;
  *g.at(kOpacityLogit, 1) = -2.5f;
  size_t widths[kAttributeCount];
  OneGaussian<const float> a, b, both;
  OneGaussian<float> out;
  for (int k = 0; k < kAttributeCount; ++k) {
    widths[k] = size_t(g.width(k));
    a.values[k] = g.at(Attribute(k), 0);
    b.values[k] = g.at(Attribute(k), 1);
    out.values[k] = g.at(Attribute(k), 2);
    both.values[k] = out.values[k];
  }
  const Merged merged = MergeTwo(a, b, widths, out);
  const double of_a = Coverage(a), of_b = Coverage(b), share = of_b / (of_a + of_b);
  EXPECT_NEAR(Coverage(both), of_a + of_b, 1e-5 * of_a);
  const auto covariance = [&](size_t i) {
    const float *q = g.at(kRotation, i), *s = g.at(kScaleLog, i);
    return math::Covariance(
        math::Quat<double>{q[0], q[1], q[2], q[3]},
        math::Vec3<double>{std::exp(double(s[0])), std::exp(double(s[1])), std::exp(double(s[2]))});
  };
  const auto ca = covariance(0), cb = covariance(1), cm = covariance(2);
  double apart[3], squared = 0;
  for (size_t k = 0; k < 3; ++k) {
    apart[k] = double(g.at(kPosition, 1)[k]) - double(g.at(kPosition, 0)[k]);
    squared += apart[k] * apart[k];
    EXPECT_NEAR(g.at(kPosition, 2)[k], g.at(kPosition, 0)[k] + share * apart[k], 1e-5);
    EXPECT_NEAR(g.at(kColorDc, 2)[k],
                (1 - share) * g.at(kColorDc, 0)[k] + share * g.at(kColorDc, 1)[k],
                1e-5);
  }
  const double between = share * (1 - share);
  EXPECT_NEAR(merged.share, share, 1e-12);
  EXPECT_NEAR(merged.lost, between * squared, 1e-9);
  const auto expect = [&](double sum, double x, double y, int i, int k) {
    EXPECT_NEAR(sum, (1 - share) * x + share * y + between * apart[i] * apart[k], 1e-6);
  };
  expect(cm.xx, ca.xx, cb.xx, 0, 0);
  expect(cm.xy, ca.xy, cb.xy, 0, 1);
  expect(cm.xz, ca.xz, cb.xz, 0, 2);
  expect(cm.yy, ca.yy, cb.yy, 1, 1);
  expect(cm.yz, ca.yz, cb.yz, 1, 2);
  expect(cm.zz, ca.zz, cb.zz, 2, 2);
}

// Two in one place, invisible ones, points without extent: nothing becomes NaN.
TEST(MergeTwo, StaysFinite) {
  for (const float opacity : {-5.0f, 0.0f, 200.0f})
    for (const float scale : {-60.0f, -3.0f, 39.0f}) {
      Gaussians g = RandomGaussians(2000, 0, Basis::kSh, 2);
      std::fill(g.values[kPosition].begin(), g.values[kPosition].end(), 0.25f);
      std::fill(g.values[kOpacityLogit].begin(), g.values[kOpacityLogit].end(), opacity);
      std::fill(g.values[kScaleLog].begin(), g.values[kScaleLog].end(), scale);
      const Gaussians one = BuildLevels(std::move(g)).Coarsest();
      for (const Buffer<float>& values : one.values)
        for (const float x : values) ASSERT_TRUE(std::isfinite(x)) << opacity << " " << scale;
    }
}

TEST(FrameBudget, FollowsTheTimesOfImages) {
  FrameBudget budget(40);
  // Blocks are not divided, so that an image has fewer than allowed.
  const auto draw = [&](int images, double per_gaussian) {
    for (int i = 0; i < images; ++i)
      budget.Drawn(budget.max() - 700, per_gaussian * double(budget.max() - 700));
  };
  draw(60, 1e-4);
  EXPECT_NEAR(double(budget.max()), 400000, 1000);
  draw(1, 5e-5);
  EXPECT_NEAR(double(budget.max()), 400000 / 0.9, 1000) << "rises little by little";
  draw(1, 5e-4);
  EXPECT_NEAR(double(budget.max()), 80000, 100) << "falls at once";
  budget.Drawn(100, 1000);
  EXPECT_NEAR(double(budget.max()), 80000, 100) << "an almost empty image says nothing";
  draw(3, 1e9);
  EXPECT_EQ(budget.max(), 50000u);
  draw(60, 1e-4);
  EXPECT_NEAR(double(budget.max()), 400000, 1000) << "comes back";
}

class LevelsFile : public testing::Test {
 protected:
  LevelsFile() : path_(folder_ / "a.levels") {
    WriteLevels(path_, levels_);
    bytes_ = ReadFile(path_);
  }
  void Change(size_t at, const void* to, size_t size) {
    std::vector<char> changed = bytes_;
    std::memcpy(changed.data() + at, to, size);
    WriteFileAtomically(path_, std::string(changed.begin(), changed.end()));
  }
  void ExpectRefused(const std::vector<std::string>& parts) {
    std::vector<std::string> all = parts;
    all.push_back(path_);
    ExpectError([&] { OpenLevels(path_); }, all);
  }

  const TemporaryFolder folder_;
  const std::string path_;
  const SceneLevels levels_ = BuildLevels(Scene());
  std::vector<char> bytes_;
};

TEST_F(LevelsFile, HoldsTheLevels) {
  EXPECT_TRUE(IsLevelsFile(path_));
  EXPECT_FALSE(IsLevelsFile(folder_ / "absent"));
  LevelRenderer written(levels_), read(OpenLevels(path_));
  EXPECT_EQ(read.levels().size(), levels_.size());
  EXPECT_EQ(read.levels().layout.degree, 1);
  EXPECT_EQ(Drawn(read, From(3), {1}).color, Drawn(written, From(3), {1}).color);
}

// Version 1 of the format; with COSPLAT_WRITE_GOLDEN set, written anew.
TEST(LevelsGolden, IsRead) {
  const std::string path = std::string(COSPLAT_SOURCE_DIR) + "/tests/golden/levels_v1.levels";
  Gaussians scene = RandomGaussians(40, 1, Basis::kSh, 1);
  scene.antialiased = true;
  if (std::getenv("COSPLAT_WRITE_GOLDEN")) WriteLevels(path, BuildLevels(scene));
  LevelRenderer renderer(OpenLevels(path));
  EXPECT_EQ(renderer.levels().size(), 40u);
  EXPECT_LT(LargestDifference(Drawn(renderer, From(3), {0}), Image(scene, From(3))), 2e-4f);
}

TEST_F(LevelsFile, ReplacingItDoesNotDisturbWhoHasItOpen) {
  LevelRenderer written(levels_), read(OpenLevels(path_));
  WriteLevels(path_, BuildLevels(Scene(2000)));
  EXPECT_EQ(Drawn(read, From(3), {1}).color, Drawn(written, From(3), {1}).color);
}

TEST_F(LevelsFile, DamageIsFoundBeforeItIsShown) {
  Change(bytes_.size() - 8, "damaged!", 8);  // of the block that stands for all
  LevelRenderer renderer(OpenLevels(path_));
  const std::string last = "blocks[" + std::to_string(levels_.blocks.size() - 1) + "]";
  const LevelLimits coarse{0, 1}, fine{0};
  const RenderedImage before = Drawn(renderer, From(3), fine);
  for (int again = 0; again < 2; ++again)
    ExpectError([&] { Drawn(renderer, From(3), coarse); }, {path_, last, "damaged"});
  EXPECT_EQ(Drawn(renderer, From(3), fine).color, before.color);
  ExpectError([&] { OpenLevels(path_).Coarsest(); }, {path_, last, "damaged"});

  Change(100, "damaged!", 8);
  ExpectRefused({"blocks", "damaged"});
}

TEST_F(LevelsFile, WhatIsNoLevelsFileIsRefused) {
  ExpectError([&] { OpenLevels(folder_ / "absent"); }, {"absent", "No such file"});
  for (const size_t size : {size_t(0), size_t(20), size_t(200), bytes_.size() - 4}) {
    WriteFileAtomically(path_, std::string(bytes_.begin(), bytes_.begin() + long(size)));
    ExpectRefused({});
  }
  Change(0, "x", 1);
  ExpectRefused({"no levels of detail"});
  const uint32_t format = 9;
  Change(8, &format, sizeof format);
  ExpectRefused({"format", "9"});
  for (const uint64_t gaussians : {uint64_t(0), uint64_t(1) << 60}) {
    Change(24, &gaussians, sizeof gaussians);
    ExpectRefused({"gaussians", "do not fit"});
  }
  const uint64_t fewer = levels_.size() - 1;
  Change(24, &fewer, sizeof fewer);
  ExpectRefused({"bytes, expected"});
}

// Files whose checksum is right.
TEST_F(LevelsFile, HostileBlocksAreRefused) {
  const auto with = [&](const std::function<void(SceneLevels&)>& change) {
    SceneLevels levels = levels_;
    change(levels);
    WriteLevels(path_, levels);
  };
  with([](SceneLevels& l) { l.blocks[1].max[2] = NAN; });
  ExpectRefused({"blocks[1]", "bounds"});
  with([](SceneLevels& l) { l.blocks[1].coarseness = -1; });
  ExpectRefused({"blocks[1]", "bounds"});
  with([](SceneLevels& l) { l.layout.basis = Basis(77); });
  ExpectRefused({"basis", "77"});
  const uint32_t seven = 7;
  Change(12, &seven, sizeof seven);
  ExpectRefused({"degree", "7"});
  Change(20, &seven, sizeof seven);
  ExpectRefused({"antialiased", "7"});
  ExpectError([&] { WriteLevels(path_, SceneLevels{}); }, {path_, "can be seen"});
}

}  // namespace
}  // namespace cosplat::test
