// Masks that rules of pruning learn, on the device against the rules themselves.
#include <gtest/gtest.h>

#include <optional>

#include "splat/device/cuda/stream.h"
#include "splat/prune/pruner.h"
#include "splat/train/cuda/mask_learner.h"
#include "tests/parity/device_fixture.h"
#include "tests/parity/training_run.h"

namespace cosplat {
namespace {

constexpr size_t kCount = 70;

class MaskParity : public test::DeviceTest {
 protected:
  void Begin(PruneRule rule) {
    PruneSettings settings;
    settings.rule = rule;
    pruner = MakePruner(settings, Schedule::Fractions(300), 300, kCount);
    SceneSubject subject(test::TrainingRun::Frames(true), 1);
    test::PicturesOf pictures(subject, gaussians);
    const std::vector<uint32_t> frames{0};
    pruner->Rank({195, pictures, frames, gaussians, {}, 0, {0, 0, 0}, rng});  // LP begins
    overflowed.Refill(1);
    overflowed.FillWithZeros(stream().get());
    device_gaussians.Upload(gaussians, stream().get());
    learner.Upload(pruner->Mask(), stream().get());
    stream().Wait();
  }

  cuda::Stream& stream() {
    if (!stream_) stream_.emplace();
    return *stream_;
  }

  // Of both, with the same gradients: pictures ask for every second Gaussian, and draw it in every
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
    device_gradients.Upload(gradients, stream().get());
    device_radii.Upload(radii.data(), radii.size(), stream().get());
    WorldGaussians world = ViewOf(gaussians), device_world = device_gaussians.View();
    const Rng before = rng;
    learner.BeforeDraw(device_gaussians, before, device_world, stream().get());
    pruner->BeforeDraw(gaussians, world, rng);
    EXPECT_EQ(before.After(learner.DrawsOf(kCount)).state, rng.state);
    learner.AfterBackward(device_gaussians,
                          std::as_const(device_radii).view(),
                          overflowed.data(),
                          device_gradients,
                          stream().get());
    const double value = pruner->AfterBackward(gaussians, gradients, radii);
    cuda::Readback<double> device_value;
    EXPECT_NEAR(device_value.Get(learner.value(), stream().get()), value, 1e-5 * value) << step;
    ExpectNear(device_world.opacity_logit, world.opacity_logit, 1e-3f);
    ExpectNear(device_gradients.values[kOpacityLogit].data(),
               gradients.values[kOpacityLogit].data(),
               1e-3f);
  }

  // [kCount]; what is hidden is -100.
  void ExpectNear(const float* on_device, const float* expected, float tolerance) {
    std::vector<float> actual(kCount);
    cuda::Check(cudaMemcpyAsync(actual.data(),
                                on_device,
                                kCount * sizeof(float),
                                cudaMemcpyDeviceToHost,
                                stream().get()),
                "cudaMemcpyAsync");
    stream().Wait();
    for (size_t i = 0; i < kCount; ++i)
      ASSERT_NEAR(actual[i], expected[i], tolerance * (1 + std::abs(expected[i]))) << i;
  }

  // What was learned; the rule has the device's then.
  void ExpectSame(size_t count) {
    const LearnedMask of_rule = *pruner->Mask().learned;
    learner.Download(stream().get());
    const LearnedMask& of_device = *pruner->Mask().learned;
    EXPECT_EQ(of_device.step, of_rule.step);
    ASSERT_EQ(of_device.size(), count);
    ASSERT_EQ(of_rule.size(), count);
    for (size_t i = 0; i < count; ++i) {
      EXPECT_NEAR(of_device.value[i], of_rule.value[i], 1e-3f) << i;
      EXPECT_NEAR(of_device.m[i], of_rule.m[i], 1e-3f * (1 + std::abs(of_rule.m[i]))) << i;
    }
  }

  Gaussians gaussians = test::RandomGaussians(kCount, 0, Basis::kDcsh, 3);
  Rng rng{4};
  std::unique_ptr<Pruner> pruner;
  std::optional<cuda::Stream> stream_;  // none where there is no device
  cuda::DeviceGaussians device_gaussians, device_gradients;
  cuda::DeviceBuffer<float> device_radii;
  cuda::DeviceBuffer<uint32_t> overflowed;
  cuda::MaskLearner learner;
};

// What nothing asks for goes from just above the threshold to below it.
TEST_F(MaskParity, AHardMaskHidesTheSame) {
  Begin(PruneRule::kCompact);
  for (size_t i = 1; i < kCount; i += 2) pruner->Mask().learned->value[i] = -4.4f;
  learner.Upload(pruner->Mask(), stream().get());
  for (int step = 0; step < 60; ++step) Step(step);
  ExpectSame(kCount);
  WorldGaussians world = ViewOf(gaussians);
  pruner->BeforeDraw(gaussians, world, rng);
  EXPECT_LT(world.opacity_logit[1], -50);
  EXPECT_GT(world.opacity_logit[0], -50);
}

TEST_F(MaskParity, ASoftMaskDimsTheSame) {
  Begin(PruneRule::kLp);
  for (int step = 0; step < 60; ++step) Step(step);
  ExpectSame(kCount);
}

TEST_F(MaskParity, ItFollowsTheGaussians) {
  for (const PruneRule rule : {PruneRule::kCompact, PruneRule::kLp}) {
    Begin(rule);
    for (int step = 0; step < 5; ++step) Step(step);
    const std::vector<uint32_t> source{7, 3, 3, 0, 69, 3};
    cuda::DeviceBuffer<uint32_t> on_device;
    on_device.Upload(source.data(), source.size(), stream().get());
    learner.Gather(std::as_const(on_device).view(), 4, stream().get());
    pruner->Gather({source, {4, 5}});
    ExpectSame(source.size());
  }
}

TEST_F(MaskParity, NothingIsLearnedAfterAnOverflow) {
  Begin(PruneRule::kCompact);
  for (int step = 0; step < 3; ++step) Step(step);
  const uint32_t stop = 1;
  overflowed.Upload(&stop, 1, stream().get());
  const LearnedMask before = *pruner->Mask().learned;
  Step(3);
  learner.TakeBack(1);
  *pruner->Mask().learned = before;
  ExpectSame(kCount);
}

TEST_F(MaskParity, RulesWithoutAMaskLearnNone) {
  learner.Upload(MaskInSteps(), stream().get());
  EXPECT_FALSE(learner.learns());
  EXPECT_EQ(learner.DrawsOf(100), 0u);
}

}  // namespace
}  // namespace cosplat
