// LPIPS as a loss: its gradient against finite differences, and short trainings with it.
#include <gtest/gtest.h>
#include <omp.h>
#include <tbb/global_control.h>

#include <cmath>

#include "splat/eval/lpips.h"
#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_onnx.h"

namespace cosplat {
namespace {

using namespace test;

std::string DataFolder() { return COSPLAT_SOURCE_DIR "/../shared/data/lpips"; }

std::vector<float> RandomPlanes(int side, uint64_t seed) {
  Rng rng{seed};
  std::vector<float> planes(3 * size_t(side) * side);
  for (float& v : planes) v = rng.Uniform();
  return planes;
}

struct Slopes {
  double by_gradient, by_difference;
};

// Along a random direction.
Slopes SlopesOf(Lpips& lpips, int side, float step, uint64_t seed) {
  const std::vector<float> a = RandomPlanes(side, seed), b = RandomPlanes(side, seed + 1);
  std::vector<float> d_a, after = a, before = a, ignored;
  lpips.Evaluate(a, b, side, side, d_a);
  Rng rng{seed + 2};
  Slopes slopes{0, 0};
  for (size_t i = 0; i < a.size(); ++i) {
    // Mostly uphill: a random direction's slope is lost among its own second derivatives.
    const float along = step * (d_a[i] > 0 ? 1.0f : -1.0f) * rng.Uniform();
    after[i] += along, before[i] -= along;
    slopes.by_gradient += double(d_a[i]) * (double(after[i]) - before[i]);
  }
  slopes.by_difference = lpips.Evaluate(after, b, side, side, ignored) -
                         lpips.Evaluate(before, b, side, side, ignored);
  return slopes;
}

class LpipsLoss : public testing::Test {
 protected:
  LpipsLoss() { WriteReluLpips(folder_.path(), "tiny"); }
  const TemporaryFolder folder_;
};

// Measured: 4e-4 apart at most, where a kink is in between.
TEST_F(LpipsLoss, ItsGradientIsThatOfItsValue) {
  Lpips lpips(folder_.path());
  for (const int side : {6, 12, 23})
    for (const uint64_t seed : {1, 5}) {
      const Slopes slopes = SlopesOf(lpips, side, 3e-4f, seed);
      EXPECT_NEAR(slopes.by_gradient / slopes.by_difference, 1, 1e-3) << side << ", " << seed;
    }
}

TEST_F(LpipsLoss, ItsValueIsThatOfTheEvaluation) {
  Lpips lpips(folder_.path());
  const int side = 20;
  Image8 a(side, side, 3), b(side, side, 3);
  Rng rng{1};
  for (Image8* image : {&a, &b})
    for (uint8_t& v : image->data) v = uint8_t(rng.Below(256));
  Buffer<float> planes_a, planes_b;
  CompositeTarget(a, {0, 0, 0}, planes_a);
  CompositeTarget(b, {0, 0, 0}, planes_b);
  std::vector<float> d_a;
  EXPECT_NEAR(lpips.Evaluate(planes_a, planes_b, side, side, d_a), lpips.Distance(a, b), 1e-6);
}

TEST_F(LpipsLoss, EqualImagesAndMapsThatAreZeroHaveAGradientThatIsFinite) {
  WriteTinyLpips(folder_ / "zero", "zero");
  Lpips lpips(folder_ / "zero");
  const std::vector<float> a = RandomPlanes(16, 1), grey(a.size(), 0.5f);  // 0 for the network
  std::vector<float> d_a;
  EXPECT_EQ(lpips.Evaluate(a, a, 16, 16, d_a), 0);
  for (const float d : d_a) EXPECT_EQ(d, 0);
  lpips.Evaluate(grey, a, 16, 16, d_a);
  for (const float d : d_a) ASSERT_TRUE(std::isfinite(d));
}

struct LpipsRun {
  LpipsRun(const std::string& folder, float weight, int side = 24)
      : net(std::make_shared<Lpips>(folder)) {
    settings.crop_loss = {weight, side, net};
    settings.density.max_count = 60;  // too few for all of the images
  }
  TrainingState Run(int steps) {
    SceneSubject subject(TargetImages(TrueScene(1), Ring(6, 2.2f)), 1);
    return Train(settings, subject, FirstGaussians(60, 1), steps);
  }
  // LPIPS of views between those of the training, mean of three seeds.
  double HeldOut() {
    double sum = 0;
    const auto frames = TargetImages(TrueScene(1), Ring(5, 2.2f));
    for (const uint64_t seed : {1, 2, 3}) {
      settings.seed = seed;
      const Gaussians g = Run(200).gaussians;
      for (const TrainFrame& frame : frames)
        sum += net->Distance(ToBytes(Render(g, frame.camera).ToImage()), frame.target);
    }
    return sum / 15;
  }
  std::shared_ptr<Lpips> net;
  TrainSettings settings = ShortRun(200, 1);
};

TEST_F(LpipsLoss, LowersLpipsOnViewsHeldOut) {
  const double without = LpipsRun(folder_.path(), 0).HeldOut();
  EXPECT_LT(LpipsRun(folder_.path(), 0.5f, 40).HeldOut(), 0.95 * without);
}

TEST_F(LpipsLoss, BitsDependOnTheSeedAlone) {
  std::vector<TrainingState> states;
  const int before = omp_get_max_threads();
  for (const int threads : {1, 4, 2}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    omp_set_num_threads(threads);
    states.push_back(LpipsRun(folder_.path(), 0.1f).Run(30));
  }
  omp_set_num_threads(before);
  EXPECT_TRUE(SameBits(states[0], states[1]));
  EXPECT_TRUE(SameBits(states[0], states[2]));
  EXPECT_FALSE(SameBits(states[0], LpipsRun(folder_.path(), 0).Run(30)));
}

class LpipsLossOfSqueezeNet : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(DataFolder())) GTEST_SKIP() << "lpips is not here";
  }
};

// Measured: 2e-3 apart; 2e-2 with a step of 1e-3, which has kinks in between.
TEST_F(LpipsLossOfSqueezeNet, ItsGradientIsThatOfItsValue) {
  Lpips lpips(DataFolder());
  for (const int side : {25, 64, 101}) {
    const Slopes slopes = SlopesOf(lpips, side, 3e-5f, 1);
    EXPECT_NEAR(slopes.by_gradient / slopes.by_difference, 1, 5e-3) << side;
  }
}

TEST_F(LpipsLossOfSqueezeNet, SameBitsForAnyNumberOfThreads) {
  std::vector<std::vector<float>> gradients;
  const int before = omp_get_max_threads();
  for (const int threads : {1, 4, 2}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    omp_set_num_threads(threads);
    gradients.emplace_back();
    Lpips(DataFolder())
        .Evaluate(RandomPlanes(64, 1), RandomPlanes(64, 2), 64, 64, gradients.back());
  }
  omp_set_num_threads(before);
  EXPECT_EQ(gradients[0], gradients[1]);
  EXPECT_EQ(gradients[0], gradients[2]);
}

TEST_F(LpipsLossOfSqueezeNet, LowersLpipsOnViewsHeldOut) {
  const double without = LpipsRun(DataFolder(), 0).HeldOut();
  EXPECT_LT(LpipsRun(DataFolder(), 0.1f, 40).HeldOut(), 0.9 * without);
}

}  // namespace
}  // namespace cosplat
