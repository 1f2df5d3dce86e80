// Training on real photographs: exposures that are found and do not drift, and pixels that are
// ignored.
#include "splat/train/loss/photograph.h"

#include <gtest/gtest.h>

#include <cmath>

#include "splat/train/subject/reduced_frames.h"
#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: small scenes

constexpr int kSide = 24;

Buffer<float> RandomPlanes(size_t pixels, uint64_t seed) {
  Rng rng{seed};
  Buffer<float> planes(3 * pixels);
  for (float& value : planes) value = rng.Uniform();
  return planes;
}

Image8 RandomImage(int side, uint64_t seed) {
  Rng rng{seed};
  Image8 image(side, side, 3);
  for (uint8_t& byte : image.data) byte = uint8_t(rng.Below(256));
  return image;
}

constexpr Exposure kWarm{1.2f, 0.05f, 0, 0.02f, -0.03f, 0.9f, 0.04f, 0, 0, 0.1f, 0.7f, -0.05f};

// The left half of the image is ignored, or nothing is.
struct Compared {
  Image8 target = RandomImage(kSide, 1);
  std::vector<uint8_t> ignored = std::vector<uint8_t>(size_t(kSide) * kSide, 0);
  Buffer<float> rendered = RandomPlanes(size_t(kSide) * kSide, 2);
  Exposure exposure = kWarm;
  PhotographModel model;
  PhotometricLoss loss;
  Buffer<float> d;

  explicit Compared(bool ignores_half) {
    for (size_t i = 0; ignores_half && i < ignored.size(); ++i)
      ignored[i] = i % kSide < kSide / 2 ? 255 : 0;
  }
  TargetView view() const { return {kSide, kSide, 3, target.data.data(), ignored.data()}; }
  double Loss() {
    const Buffer<float>& shown =
        model.Forward(rendered, exposure.data(), view(), {0, 0, 0}, HostStream());
    loss.Evaluate(LossWeights(), shown, view(), {0, 0, 0}, d, HostStream());
    return *loss.value();
  }
  void Pull() { model.Backward(rendered, exposure.data(), view(), d, HostStream()); }
};

TEST(Photograph, GradientsAreThoseOfTheLoss) {
  for (const bool ignores_half : {false, true}) {
    Compared c(ignores_half);
    c.Loss();
    c.Pull();
    const Buffer<float> d_rendered = c.d, d_exposure = c.model.gradient();
    const auto slope = [&](float& value) {
      constexpr float kStep = 2e-3f;
      const float before = value;
      value = before + kStep;
      const double above = c.Loss();
      value = before - kStep;
      const double below = c.Loss();
      value = before;
      return (above - below) / (2 * kStep);
    };
    for (size_t k = 0; k < c.exposure.size(); ++k)
      EXPECT_NEAR(slope(c.exposure[k]), d_exposure[k], 2e-2 * std::abs(d_exposure[k]) + 2e-3) << k;
    for (const size_t i : {5u, 20u, 300u, 320u, 900u, 1700u}) {
      const bool ignored = ignores_half && i % kSide < kSide / 2;
      EXPECT_NEAR(slope(c.rendered[i]), d_rendered[i], ignored ? 0 : 2e-4) << i;
      if (ignored) {
        EXPECT_EQ(d_rendered[i], 0) << i;
      }
    }
  }
}

TEST(Photograph, AFitFindsTheExposure) {
  const size_t pixels = 500;
  const Buffer<float> rendered = RandomPlanes(pixels, 3);
  Buffer<float> target = rendered;
  ApplyExposure(kWarm, target.view());
  std::vector<uint8_t> use(pixels, 1);
  for (size_t i = 0; i < pixels; i += 3) {
    use[i] = 0;
    target[i] = 100;
  }
  const Exposure found = FitExposure(rendered, target, use);
  for (size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], kWarm[k], 1e-3) << k;
}

TEST(Photograph, AFitOfNothingIsTheIdentity) {
  const Buffer<float> black(size_t(30), 0.0f);
  const Exposure of_black = FitExposure(black, black, std::vector<uint8_t>(10, 1));
  const Exposure of_none = FitExposure(black, black, std::vector<uint8_t>(10, 0));
  for (size_t k = 0; k < of_black.size(); ++k) {
    EXPECT_FLOAT_EQ(of_black[k], kIdentityExposure[k]) << k;
    EXPECT_FLOAT_EQ(of_none[k], kIdentityExposure[k]) << k;
  }
}

// Of the true scene, each brighter or darker than it is.
struct UnevenScene {
  std::vector<TrainFrame> frames = TargetImages(TrueScene(0), Ring(8, 2.2f));
  std::vector<float> gains;
  UnevenScene() {
    for (size_t f = 0; f < frames.size(); ++f) {
      gains.push_back(f % 2 ? 0.6f : 0.95f);
      for (uint8_t& byte : frames[f].target.data) byte = uint8_t(float(byte) * gains[f] + 0.5f);
    }
  }
};

TEST(Photograph, TrainingFindsExposuresWhoseMeanIsTheIdentity) {
  const UnevenScene scene;
  SceneSubject subject(scene.frames, 1);
  const auto psnr = [&](const TrainingState& of) {
    std::vector<uint32_t> all;
    for (uint32_t f = 0; f < scene.frames.size(); ++f) all.push_back(f);
    const auto rasterizer = MakeCpuRasterizer();
    const auto tape = rasterizer->MakeTape();
    const FrameChoice choice{all, 0, {0, 0, 0}, all.size()};
    return ErrorOfFrames(subject, of.gaussians, choice, true, *rasterizer, *tape).mean_psnr;
  };
  double gain = 0;
  constexpr uint64_t kSeeds = 2;  // a run scatters by a decibel
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    TrainSettings settings = ShortRun(600, 0);
    settings.seed = seed;
    const TrainingState even = Train(settings, subject, FirstGaussians(200, 0), 600);
    settings.exposure = true;
    const TrainingState state = Train(settings, subject, FirstGaussians(200, 0), 600);
    gain += (psnr(state) - psnr(even)) / double(kSeeds);
    const Buffer<float>& e = state.exposures.value;
    ASSERT_EQ(e.size(), scene.frames.size() * kIdentityExposure.size());
    for (size_t k = 0; k < kIdentityExposure.size(); ++k) {
      double mean = 0;
      for (size_t i = k; i < e.size(); i += kIdentityExposure.size())
        mean += double(e[i]) / double(scene.frames.size());
      EXPECT_NEAR(mean, kIdentityExposure[k], 1e-4) << k;
    }
    // The mean gain is 0.775. What grey becomes, since channels that go together can share it.
    for (size_t f = 0; f < scene.frames.size(); ++f) {
      const math::Vec3<float> grey =
          math::Exposed(&e[f * kIdentityExposure.size()], {0.5f, 0.5f, 0.5f});
      for (const float value : {grey.x, grey.y, grey.z})
        EXPECT_NEAR(value, 0.5f * scene.gains[f] / 0.775f, 0.03f) << f;
    }
  }
  EXPECT_GT(gain, 1);
}

// With a loss that looks at single pixels, what is painted over does not change a bit.
TEST(Photograph, ExposuresFoundInPartsAreMeans) {
  constexpr size_t kNumbers = math::kExposureNumbers;
  ExposureState all(4);
  all.value[3 * kNumbers] = 5;
  const std::vector<std::vector<uint32_t>> frames{{0, 2}, {2}, {3}};
  std::vector<ExposureState> found{all.Of(frames[0]), all.Of(frames[1]), {}};
  found[0].value[0] = 2;                           // frame 0
  found[0].value[kNumbers + 1] = 4;                // frame 2
  found[0].m[kNumbers] = 1;                        //
  found[0].updates[kNumbers] = 7;                  //
  found[1].value[1] = 1, found[1].updates[0] = 9;  // frame 2
  all.SetToMeans(frames, found);
  EXPECT_EQ(all.value[0], 2);
  EXPECT_EQ(all.value[kNumbers], 1);  // of no part
  EXPECT_EQ(all.value[2 * kNumbers + 1], 2.5f);
  EXPECT_EQ(all.m[2 * kNumbers], 0.5f);
  EXPECT_EQ(all.updates[2 * kNumbers], 9u);
  EXPECT_EQ(all.value[3 * kNumbers], 5);  // its part has found nothing
  EXPECT_EQ(all.Of({3}).value[0], 5);
}

TEST(Photograph, IgnoredPixelsDoNotMatter) {
  const auto train = [](uint8_t paint, int num_downscales) {
    std::vector<TrainFrame> frames = TargetImages(TrueScene(1), Ring(4, 2.2f, 208));
    for (TrainFrame& frame : frames) {
      frame.ignored = Image8(208, 208, 1);
      for (int y = 90; y < 130; ++y)
        for (int x = 80; x < 120; ++x) {
          frame.ignored.at(x, y, 0) = 255;
          for (int c = 0; c < 3; ++c) frame.target.at(x, y, c) = paint;
        }
    }
    SceneSubject subject(std::move(frames), 1);
    TrainSettings settings = ShortRun(60, 1);
    settings.schedule.num_downscales = num_downscales;
    settings.loss = {1, 0, 0};
    return Train(settings, subject, FirstGaussians(100, 1), 60);
  };
  for (const int downscales : {0, 1})
    EXPECT_TRUE(SameBits(train(0, downscales), train(255, downscales))) << downscales;
}

TEST(Photograph, ReducedBlocksWithAnIgnoredPixelAreIgnored) {
  TrainFrame frame{LookingAt({0, 0, 3}, {0, 0, 0}).Resized(7, 4), Image8(7, 4, 3), Image8(7, 4, 1)};
  frame.ignored.at(3, 2, 0) = 255;
  frame.ignored.at(6, 0, 0) = 255;  // cropped
  const Image8 ignored = Reduced(frame, 2).ignored;
  ASSERT_EQ(ignored.width, 3);
  ASSERT_EQ(ignored.height, 2);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 3; ++x) EXPECT_EQ(ignored.at(x, y, 0) != 0, x == 1 && y == 1);
}

TEST(Photograph, TheErrorIsOfWhatIsNotIgnored) {
  std::vector<TrainFrame> frames = TargetImages(TrueScene(0), Ring(2, 2.2f));
  for (TrainFrame& frame : frames) {
    frame.ignored = Image8(frame.target.width, frame.target.height, 1);
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 20; ++x) {
        frame.ignored.at(x, y, 0) = 255;
        frame.target.at(x, y, 1) = 255;
      }
  }
  SceneSubject subject(frames, 1);
  const std::vector<uint32_t> all{0, 1};
  const Gaussians truth = TrueScene(0);
  EXPECT_GT(ImagesOf(subject, truth).ErrorIn({all, 0, {0, 0, 0}, 2}).mean_psnr, 45);
}

}  // namespace
}  // namespace cosplat
