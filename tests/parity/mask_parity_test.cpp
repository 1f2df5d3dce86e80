// Masks that rules of pruning learn, on the device against the host.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "splat/device/cuda/stream.h"
#include "splat/train/cuda/kernels.h"
#include "splat/train/prune/mask_learner.h"
#include "splat/train/prune/pruner.h"
#include "tests/parity/device_fixture.h"
#include "tests/parity/training_run.h"

namespace cosplat {
namespace {

constexpr size_t kCount = 70;

// A learner with all that it works on, in a stream's memory.
struct Side {
  Side(const MaskInSteps& begun, const Gaussians& of_host, Stream& stream)
      : stream(stream), learned(*begun.learned) {
    if (begun.importance) importance = *begun.importance;
    MaskInSteps mask = begun;
    mask.learned = &learned;
    mask.importance = begun.importance ? &importance : nullptr;
    learner.Upload(mask, stream);
    gaussians.Upload(of_host, stream);
    overflowed.Refill(1, stream);
    overflowed.FillWithZeros(stream);
    stream.Wait();
  }

  void Step(const Gaussians& d, const std::vector<float>& r, const Rng& rng) {
    gradients.Upload(d, stream);
    radii.Upload(r.data(), r.size(), stream);
    world = ViewOf(gaussians);
    learner.BeforeDraw(gaussians, rng, world, stream);
    learner.AfterBackward(gaussians, radii, overflowed.data(), gradients, stream);
    stream.Wait();
  }
  void Gather(const std::vector<uint32_t>& source, size_t first_fresh) {
    Buffer<uint32_t> there;
    there.Upload(source.data(), source.size(), stream);
    learner.Gather(there, first_fresh, stream);
    stream.Wait();
  }
  void Stop() {
    const uint32_t stop = 1;
    overflowed.Upload(&stop, 1, stream);
    stream.Wait();
  }

  double Value() { return Readback<double>(stream).Get(learner.value(), stream); }
  std::vector<float> OpacityLogits() { return Fetched(world.opacity_logit); }
  std::vector<float> Gradients() { return Fetched(gradients.values[kOpacityLogit].data()); }
  std::vector<float> Fetched(const float* from) {
    std::vector<float> to(kCount);
    stream.Download(to.data(), from, kCount * sizeof(float));
    stream.Wait();
    return to;
  }
  const LearnedMask& Learned() {
    learner.Download(stream);
    return learned;
  }

  Stream& stream;
  LearnedMask learned;
  std::vector<float> importance;
  MaskLearner learner;
  Gaussians gaussians, gradients;
  WorldGaussians world;
  Buffer<float> radii;
  Buffer<uint32_t> overflowed;
};

// Of numbers one of which a rule may have hidden: -100.
void ExpectNear(const std::vector<float>& actual, const std::vector<float>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i)
    ASSERT_NEAR(actual[i], expected[i], 1e-3f * (1 + std::abs(expected[i]))) << i;
}

void ExpectSame(const LearnedMask& actual, const LearnedMask& expected) {
  EXPECT_EQ(actual.step, expected.step);
  ASSERT_EQ(actual.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(actual.value[i], expected.value[i], 1e-3f) << i;
    EXPECT_NEAR(actual.m[i], expected.m[i], 1e-3f * (1 + std::abs(expected.m[i]))) << i;
  }
}

class MaskParity : public test::DeviceTest {
 protected:
  // of_odd: the numbers that every second Gaussian begins with, where they are others.
  void Begin(const std::string& rule, std::optional<float> of_odd = {}) {
    cuda::ProvideTrainKernels();
    PruneSettings settings;
    settings.rule = rule;
    const auto pruner = MakePruner(settings, Schedule::Fractions(300), 300, kCount);
    SceneSubject subject(test::TrainingRun::Frames(true), 1);
    test::ImagesOf images(subject, gaussians);
    const std::vector<uint32_t> frames{0};
    pruner->Rank({195, images, frames, gaussians, {}, 0, {0, 0, 0}, rng});  // LP begins
    const MaskInSteps mask = pruner->Mask();
    for (size_t i = 1; of_odd && i < kCount; i += 2) mask.learned->value[i] = *of_odd;
    if (!stream) stream.emplace();
    host.emplace(mask, gaussians, HostStream());
    device.emplace(mask, gaussians, *stream);
  }

  // Of both, with the same gradients: images ask for every second Gaussian, and draw it in every
  // second step.
  void Step(int step) {
    Gaussians gradients = gaussians.ZerosLike();
    std::vector<float> radii(kCount, 0.0f);
    for (size_t i = 0; i < kCount; i += 2) {
      *gradients.at(kOpacityLogit, i) = -1 - 0.01f * float(i);
      gradients.at(kScaleLog, i)[1] = 0.001f * float(step % 7);
      radii[i] = float((i / 2 + step) % 2);
    }
    gradients.at(kScaleLog, 4)[1] = NAN;
    for (Side* side : {&*host, &*device}) side->Step(gradients, radii, rng);
    EXPECT_EQ(device->learner.DrawsOf(kCount), host->learner.DrawsOf(kCount));
    rng = rng.After(host->learner.DrawsOf(kCount));
    const double value = host->Value();
    EXPECT_NEAR(device->Value(), value, 1e-5 * value) << step;
    ExpectNear(device->OpacityLogits(), host->OpacityLogits());
    ExpectNear(device->Gradients(), host->Gradients());
  }

  Gaussians gaussians = test::RandomGaussians(kCount, 0, Basis::kDcsh, 3);
  Rng rng{4};
  std::optional<cuda::CudaStream> stream;  // none where there is no device
  std::optional<Side> host, device;
};

// What nothing asks for goes from just above the threshold to below it.
TEST_F(MaskParity, AHardMaskHidesTheSame) {
  Begin("compact", -4.4f);
  for (int step = 0; step < 60; ++step) Step(step);
  EXPECT_EQ(host->learner.DrawsOf(kCount), 0u);
  ExpectSame(device->Learned(), host->Learned());
  Step(60);
  EXPECT_LT(device->OpacityLogits()[1], -50);
  EXPECT_GT(device->OpacityLogits()[0], -50);
}

TEST_F(MaskParity, ASoftMaskDimsTheSame) {
  Begin("lp");
  for (int step = 0; step < 60; ++step) Step(step);
  EXPECT_EQ(host->learner.DrawsOf(kCount), math::kMaskDraws * kCount);
  ExpectSame(device->Learned(), host->Learned());
}

TEST_F(MaskParity, ItFollowsTheGaussians) {
  for (const char* rule : {"compact", "lp"}) {
    Begin(rule);
    for (int step = 0; step < 5; ++step) Step(step);
    const LearnedMask before = device->Learned();
    const std::vector<float> importance = device->importance;
    const std::vector<uint32_t> source{7, 3, 3, 0, 69, 3};
    for (Side* side : {&*host, &*device}) side->Gather(source, 4);
    const LearnedMask& after = device->Learned();
    ExpectSame(after, host->Learned());
    ASSERT_EQ(after.size(), source.size());
    for (size_t i = 0; i < source.size(); ++i) {
      EXPECT_EQ(after.value[i], before.value[source[i]]) << i;
      EXPECT_EQ(after.m[i], i < 4 ? before.m[source[i]] : 0.0f) << i;
      EXPECT_EQ(after.v[i], i < 4 ? before.v[source[i]] : 0.0f) << i;
      if (!importance.empty()) {
        EXPECT_EQ(device->importance[i], importance[source[i]]) << i;
      }
    }
  }
}

TEST_F(MaskParity, NothingIsLearnedAfterAnOverflow) {
  Begin("compact");
  for (int step = 0; step < 3; ++step) Step(step);
  const LearnedMask before = device->Learned();
  for (Side* side : {&*host, &*device}) side->Stop();
  Step(3);
  for (Side* side : {&*host, &*device}) {
    side->learner.TakeBack(1);
    ExpectSame(side->Learned(), before);
  }
}

TEST_F(MaskParity, RulesWithoutAMaskLearnNone) {
  cuda::CudaStream stream;
  MaskLearner learner;
  learner.Upload(MaskInSteps(), stream);
  EXPECT_FALSE(learner.learns());
  EXPECT_EQ(learner.DrawsOf(100), 0u);
}

}  // namespace
}  // namespace cosplat
