// apps/study/bench: what is measured is what its names say. No timing is asserted.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "apps/study/bench/bench_scene.h"
#include "apps/study/bench/dense_tile.h"
#include "apps/study/bench/held_memory.h"
#include "apps/study/bench/machine.h"
#include "apps/study/bench/step_timer.h"
#include "apps/study/bench/synthetic_view.h"
#include "splat/base/rng.h"
#include "splat/config.h"
#include "splat/eval/metrics.h"
#include "splat/math/adam.h"
#include "splat/render/rasterizer.h"
#include "splat/train/optimize/optimizer.h"

namespace cosplat::test {
namespace {

void ExpectFiniteAndPositive(double value) {
  EXPECT_TRUE(std::isfinite(value)) << value;
  EXPECT_GT(value, 0);
}

TEST(BenchMachine, NamesItselfAndItsInstructionSets) {
  EXPECT_FALSE(CpuName().empty());
  const std::vector<SimdTarget> targets = SimdTargets();
  ASSERT_FALSE(targets.empty());
  for (const SimdTarget& target : targets) {
    const OnlySimdTarget only(target);
    ASSERT_EQ(SimdTargets().size(), 1u);
    EXPECT_EQ(SimdTargets()[0].name, target.name);
  }
  EXPECT_EQ(SimdTargets().size(), targets.size());
}

TEST(BenchMachine, MeasuresItsCeilings) {
  for (const SimdTarget& target : SimdTargets()) {
    const OnlySimdTarget only(target);
    ExpectFiniteAndPositive(FmaPeakGflops(1));
  }
  for (const bool all_cores : {false, true}) ExpectFiniteAndPositive(StreamGbs(1, all_cores, 1));
}

// The packs' exp differs from the standard library's by less than 6e-7.
TEST(BenchDenseTile, EveryInstructionSetComputesTheSame) {
  const BlendTimes scalar = MeasureScalarBlend(1);
  ExpectFiniteAndPositive(scalar.forward_ns);
  ExpectFiniteAndPositive(scalar.backward_ns);
  for (const SimdTarget& target : SimdTargets()) {
    const OnlySimdTarget only(target);
    const BlendTimes times = MeasureBlend(1);
    EXPECT_NEAR(times.checksum, scalar.checksum, 1e-5 * std::abs(scalar.checksum)) << target.name;
    ExpectFiniteAndPositive(times.forward_ns);
    ExpectFiniteAndPositive(times.backward_ns);
  }
}

// A camera at the origin with an image of `side` px, and a round splat of `sigma` px in its
// middle.
Camera MiddleCamera(int side) {
  Camera c;
  c.width = c.height = side;
  c.fx = c.fy = 1000;
  c.cx = c.cy = 0.5f * float(side);
  return c;
}
Gaussians Splats(size_t count, float sigma_px, float opacity_logit) {
  Gaussians g;
  g.Resize(count);
  for (size_t i = 0; i < count; ++i) {
    g.at(kPosition, i)[2] = 1 + 0.001f * float(i);
    g.at(kRotation, i)[0] = 1;
    for (int k = 0; k < 3; ++k) g.at(kScaleLog, i)[k] = std::log(sigma_px / 1000);
    *g.at(kOpacityLogit, i) = opacity_logit;
  }
  return g;
}

// Pixels whose centre is where opacity exp(-r^2 / (2 variance)) is at least kMinAlpha.
uint64_t PixelsWithin(int side, double sigma, double opacity) {
  const double variance = sigma * sigma + kBlurVariance;
  uint64_t count = 0;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double dx = x + 0.5 - 0.5 * side, dy = y + 0.5 - 0.5 * side;
      count += opacity * std::exp(-(dx * dx + dy * dy) / (2 * variance)) >= kMinAlpha;
    }
  return count;
}

TEST(BenchPairCounts, CountsThePixelsOfOneSplat) {
  const PairCounts counts = CountPairs(Splats(1, 9, 0), MiddleCamera(70));
  EXPECT_EQ(counts.contributing, PixelsWithin(70, 9, 0.5));
  EXPECT_GE(counts.evaluated, counts.contributing);
  EXPECT_LE(counts.evaluated, 70u * 70u);
}

TEST(BenchPairCounts, NothingIsCountedBehindWhatIsOpaque) {
  // Alpha 1/2 everywhere: the fourteenth brings the transmittance below kMinTransmittance, and the
  // sixteenth is the last before the loop looks.
  static_assert(kStopInterval == 16);
  const PairCounts counts = CountPairs(Splats(50, 3000, 0), MiddleCamera(40));
  EXPECT_EQ(counts.contributing, 14u * 40u * 40u);
  EXPECT_EQ(counts.evaluated, 16u * 40u * 40u);
  EXPECT_EQ(CountPairs(Splats(0, 1, 0), MiddleCamera(40)).evaluated, 0u);
}

TEST(BenchSyntheticView, TheSameSeedGivesTheSameBits) {
  const SyntheticView a = MakeSyntheticView(500, 64, 48, 3), b = MakeSyntheticView(500, 64, 48, 3);
  EXPECT_EQ(a.frame.target.data, b.frame.target.data);
  for (int i = 0; i < kAttributeCount; ++i) EXPECT_EQ(a.start.values[i], b.start.values[i]);
  EXPECT_NE(a.frame.target.data, MakeSyntheticView(500, 64, 48, 4).frame.target.data);
}

// Measured: 46.7, 51.3 and 49.4 splats per pixel.
TEST(BenchSyntheticView, CoversTheImageEquallyWhateverTheCount) {
  constexpr int kSide = 160;
  std::vector<double> per_pixel;
  for (const size_t count : {1000u, 10000u, 100000u}) {
    const SyntheticView view = MakeSyntheticView(count, kSide, kSide, 5);
    ASSERT_EQ(view.start.size(), count);
    const PairCounts counts = CountPairs(view.start, view.frame.camera);
    per_pixel.push_back(double(counts.contributing) / (kSide * kSide));
  }
  for (const double n : per_pixel) EXPECT_NEAR(n, per_pixel[0], 0.15 * per_pixel[0]);
}

// A chair trained at 800x800 has 2.39 tiles per Gaussian drawn, 2.9 blocks per tile and Gaussian,
// and 11.4 splats that contribute to a pixel (mean of six views).
TEST(BenchSyntheticView, AsTrainedHasTheWorkOfATrainedScene) {
  constexpr int kSide = 400;
  const SyntheticView view = MakeTrainedView(kSide, kSide, 7);
  ASSERT_EQ(view.start.size(), size_t(kTrainedPerPixel * kSide * kSide));
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(ViewOf(view.start),
                      view.start.basis,
                      view.frame.camera,
                      {{0, 0, 0}, view.start.degree},
                      image,
                      *tape);
  const PairCounts counts = CountPairs(view.start, view.frame.camera);
  EXPECT_NEAR(double(tape->counts()->instances) / double(tape->counts()->visible), 2.4, 0.3);
  EXPECT_NEAR(double(counts.evaluated) / 16 / double(tape->counts()->instances), 2.9, 1);
  EXPECT_NEAR(double(counts.contributing) / (kSide * kSide), 11.4, 4);
}

// Of the bound: tests/splat/allocation_test.cpp.
TEST(BenchHeldMemory, OfASyntheticView) {
  constexpr size_t kCount = 20000, kPixels = 128 * 96;
  const auto parts = MemoryOfSteps(MakeSyntheticView(kCount, 128, 96, 1), 2);
  EXPECT_LE(SumOf(parts, MemoryOf::kGaussians), 1300 * kCount);
  EXPECT_GE(SumOf(parts, MemoryOf::kPixels), 7 * sizeof(float) * kPixels);  // two images, alpha
}

// No figure is asserted: sanitizers add their own to what is resident.
TEST(BenchHeldMemory, TheSystemSeesItGrow) {
  ExpectFiniteAndPositive(ResidentBytesPerGaussian(10000, 50000, 128));
}

TEST(BenchStepTimer, TimesStepsAndTheirPhases) {
  const SyntheticView view = MakeSyntheticView(300, 48, 32, 6);
  const StepTimes times = TimeSteps(view, 1, 3);
  ExpectFiniteAndPositive(times.fastest_ms);
  EXPECT_GE(times.mean_ms, 0.9 * times.fastest_ms);  // the trainer's clock starts a little later
  double phases = 0;
  for (const double seconds : times.mean_phases.seconds) phases += 1e3 * seconds;
  EXPECT_GT(phases, 0);
  EXPECT_LE(phases, times.mean_ms);
}

TEST(BenchStepTimer, TimesStepsWithShortcuts) {
  const SyntheticView view = MakeSyntheticView(300, 48, 32, 6);
  ExpectFiniteAndPositive(
      TimeSteps({view.frame}, view.start, 1, 2, {kMinExpDegree, AdamOn::kAll}).fastest_ms);
}

}  // namespace
}  // namespace cosplat::test
