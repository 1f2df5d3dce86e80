// Short trainings of an avatar on the device against the CPU's: walking, density control, the
// track.
#include <gtest/gtest.h>

#include <cmath>

#include "avatar/train/avatar_subject.h"
#include "splat/render/cuda/tape.h"
#include "tests/avatar/made_video.h"
#include "tests/parity/device_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using cuda::SumOrder;

class AvatarTrainingParity : public test::DeviceTest {};

AvatarSettings Avatar() {
  AvatarSettings avatar = test::SmallAvatar(250);
  avatar.walk_every = 8;
  return avatar;
}

// Of 5 frames of 96 / resolution pixels a side.
struct AvatarRun {
  AvatarSubject subject;
  TrainSettings settings;
  Trainer trainer;
  std::vector<double> losses;

  AvatarRun(const AvatarSettings& avatar,
            std::optional<SumOrder> order,
            int steps,
            int of = 40,
            int resolution = 4)
      : subject(test::MadeHead().model, test::MakeSmallVideo(5, resolution), avatar),
        settings(SettingsOf(subject, of)),
        trainer(settings,
                subject,
                subject.InitialGaussians(1, Basis::kDcsh, 3),
                AvatarEngineOn(order ? Device::kCuda : Device::kCpu, order == SumOrder::kFixed)) {
    for (int i = 0; i < steps; ++i) losses.push_back(trainer.Step().loss);
  }
  static TrainSettings SettingsOf(const AvatarSubject& subject, int iterations) {
    TrainSettings settings = test::ShortRun(iterations, 400);
    settings.degree = 1;
    ScaleToUnit(subject.extent(), settings);
    return settings;
  }
};

double Quality(const AvatarRun& run) {
  return test::MeanPsnr(
      run.subject.Model(run.trainer.CaughtUp()), run.subject.video(), run.subject.video().train);
}

// From the second step on a device tells the loss of the step before. Roundings grow, and a
// Gaussian that walks or splits in one run and not in the other makes them large.
void ExpectSameLosses(const AvatarRun& cpu, const AvatarRun& device, int near_until) {
  EXPECT_NEAR(device.losses[0], cpu.losses[0], 1e-5 * cpu.losses[0]);
  for (size_t i = 1; i < device.losses.size(); ++i) {
    const double bound = int(i) < near_until ? 1e-3 : 0.25;
    EXPECT_NEAR(device.losses[i], cpu.losses[i - 1], bound * cpu.losses[i - 1]) << i;
  }
}

TEST_F(AvatarTrainingParity, EndsAsGoodAsOnTheCpu) {
  constexpr int kSteps = 40;
  const AvatarRun cpu(Avatar(), {}, kSteps), device(Avatar(), SumOrder::kAny, kSteps);
  ExpectSameLosses(cpu, device, 6);
  EXPECT_NE(device.trainer.count(), 250u) << "density was controlled";
  EXPECT_NEAR(double(device.trainer.count()) / double(cpu.trainer.count()), 1, 0.1);
  EXPECT_NEAR(Quality(device), Quality(cpu), 1);
  EXPECT_GT(device.subject.WalkedShare(), 0);
}

// Roundings decide who splits and who crosses an edge, so that long runs part. The bounds are about
// the CPU's own: seven of its runs whose first scales differ by up to three roundings end with 257
// to 271 Gaussians and 33.2 to 34.6 dB, one compiled for another instruction set with 269 and 33.0
// dB, the emulated device with 259 and 34.6 dB. (250 Gaussians at
// 24 x 24 pixels, in eight times the time: 386 to 388 and 33.56 to 33.71 dB, the device 388 and
// 33.71 dB.)
TEST_F(AvatarTrainingParity, ALongRunEndsWhereTheCpusMayEnd) {
  constexpr int kSteps = 300;
  AvatarSettings avatar = test::SmallAvatar(60);
  const AvatarRun cpu(avatar, {}, kSteps, kSteps, 8);
  const AvatarRun device(avatar, SumOrder::kFixed, kSteps, kSteps, 8);
  EXPECT_GT(device.trainer.count(), 200u);
  EXPECT_NEAR(double(device.trainer.count()) / double(cpu.trainer.count()), 1, 0.08);
  EXPECT_NEAR(Quality(device), Quality(cpu), 2.5);
}

TEST_F(AvatarTrainingParity, AFixedOrderGivesTheSameBits) {
  const AvatarRun first(Avatar(), SumOrder::kFixed, 10), again(Avatar(), SumOrder::kFixed, 10);
  EXPECT_EQ(first.losses, again.losses);
  for (int a = 0; a < kAttributeCount; ++a)
    EXPECT_EQ(first.trainer.state().gaussians.values[a], again.trainer.state().gaussians.values[a]);
  EXPECT_EQ(first.subject.State().embedding.triangle, again.subject.State().embedding.triangle);
}

TEST_F(AvatarTrainingParity, FindsTheBust) {
  AvatarSettings avatar = Avatar();
  avatar.bust = AvatarSettings::BustChoice::kYes;
  avatar.iterations = 40;
  const AvatarRun cpu(avatar, {}, 6), device(avatar, SumOrder::kFixed, 6);
  ExpectSameLosses(cpu, device, 6);
  const auto on_cpu = cpu.subject.State().busts, there = device.subject.State().busts;
  ASSERT_EQ(on_cpu.size(), cpu.subject.frame_count());
  ASSERT_EQ(there.size(), on_cpu.size());
  float moved = 0;
  for (size_t i = 0; i < there.size(); ++i) {
    moved = std::max(moved, std::abs(on_cpu[i].pose.shift.x));
    EXPECT_EQ(there[i].adam.step, on_cpu[i].adam.step);
    EXPECT_NEAR(there[i].pose.shift.x, on_cpu[i].pose.shift.x, 2e-5f);
    EXPECT_NEAR(there[i].pose.turn.y, on_cpu[i].pose.turn.y, 2e-4f);
  }
  EXPECT_GT(moved, 1e-4f);
}

TEST_F(AvatarTrainingParity, FindsTheLight) {
  const AvatarRun cpu(Avatar(), {}, 6), device(Avatar(), SumOrder::kFixed, 6);
  const LightState on_cpu = cpu.subject.State().lights.at(0);
  const LightState there = device.subject.State().lights.at(0);
  EXPECT_EQ(there.adam.step, on_cpu.adam.step);
  float moved = 0;
  for (size_t k = 0; k < kLightNumbers; ++k) {
    moved = std::max(moved, std::abs(on_cpu.value[k]));
    EXPECT_NEAR(there.value[k], on_cpu.value[k], 2e-3f) << k;
  }
  EXPECT_GT(moved, 1e-2f);
}

TEST_F(AvatarTrainingParity, LearnsCorrections) {
  AvatarSettings avatar = Avatar();
  avatar.corrections = 3;
  const AvatarRun cpu(avatar, {}, 12), device(avatar, SumOrder::kFixed, 12);
  ExpectSameLosses(cpu, device, 6);
  const Gaussians &a = cpu.trainer.state().gaussians, &b = device.trainer.state().gaussians;
  EXPECT_EQ(a.corrections, 3);
  EXPECT_EQ(b.corrections, 3);
  EXPECT_EQ(b.values[kCorrection].size(), b.size() * size_t(b.width(kCorrection)));
  EXPECT_NEAR(Quality(device), Quality(cpu), 0.5);
}

TEST_F(AvatarTrainingParity, RefinesTheTrack) {
  AvatarSettings avatar = Avatar();
  avatar.refine_track = true;
  const AvatarRun cpu(avatar, {}, 6), device(avatar, SumOrder::kFixed, 6),
      as_tracked(Avatar(), {}, 0);
  ExpectSameLosses(cpu, device, 6);
  const auto first = as_tracked.subject.RefinedTrack();
  const auto cpu_track = cpu.subject.RefinedTrack(), device_track = device.subject.RefinedTrack();
  double change = 0, difference = 0;
  for (size_t f = 0; f < cpu.subject.frame_count(); ++f) {
    const auto& before = first[f].expression;
    const auto& on_cpu = cpu_track[f].expression;
    const auto& on_device = device_track[f].expression;
    for (size_t k = 0; k < before.size(); ++k) {
      change += std::pow(on_cpu[k] - before[k], 2);
      difference += std::pow(on_cpu[k] - on_device[k], 2);
    }
  }
  EXPECT_GT(change, 0);
  EXPECT_LE(std::sqrt(difference), 0.02 * std::sqrt(change));
}

TEST_F(AvatarTrainingParity, TheReleasedRuleIsTheCpus) {
  AvatarSettings avatar = Avatar();
  avatar.system = AvatarSystem::kReleased;
  test::ExpectError([&] { AvatarRun(avatar, SumOrder::kAny, 1); }, {"released", "CPU"});
}

}  // namespace
}  // namespace cosplat
