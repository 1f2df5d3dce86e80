// Steps that are submitted without waiting, which only the emulated device can count; and steps
// that are done again because they had more instances than was expected.
#include <gtest/gtest.h>

#include "splat/device/cuda/stream.h"
#include "splat/render/device.h"
#include "splat/train/subject/target_store.h"
#include "tests/parity/device_fixture.h"
#include "tests/parity/training_run.h"

namespace cosplat {
namespace {

using cuda_on_host::Waits;
using test::TrainingRun;

class NoWait : public test::DeviceTest {};

StepEngineMaker WithMargin(double margin) {
  return test::OnDevice(cuda::SumOrder::kFixed, InstanceForecast(margin));
}

Waits Since(const Waits& before) {
  const Waits now = cuda_on_host::WaitsSoFar();
  return {now.all - before.all, now.idle - before.idle};
}

// One wait for the step before, while the step itself is left to do.
TEST_F(NoWait, AStepIsAlwaysQueued) {
  TrainingRun run;
  run.settings.schedule.densify_until = 0;
  run.settings.schedule.opacity_reset_every = 1000;
  run.settings.scale_regularizer = {0.5f, 0.01f, 1.2f};
  SceneSubject subject(run.frames, 1);
  Trainer trainer(run.settings, subject, run.first, WithMargin(4));
  for (int i = 0; i < 8; ++i) trainer.Step();  // every image was sent, every array has grown
  for (int i = 0; i < 6; ++i) {
    const Waits before = cuda_on_host::WaitsSoFar();
    trainer.Step();
    EXPECT_EQ(Since(before).all, 1u) << i;
    EXPECT_EQ(Since(before).idle, 0u) << i;
  }
}

TEST_F(NoWait, PhotographsAreSentMeanwhile) {
  const TrainingRun run;
  SceneSubject subject(run.frames, 1);
  cuda::CudaStream stream;
  TargetStore images(subject, 0);
  images.Of(0, 1, stream);
  images.Of(1, 1, stream);  // pinned memory for both
  stream.Wait();
  const Waits before = cuda_on_host::WaitsSoFar();
  images.Of(2, 1, stream);
  images.Of(3, 1, stream);
  EXPECT_EQ(Since(before).all, 0u);
  images.Of(0, 1, stream);
  EXPECT_EQ(Since(before).all, 1u) << "for the last but one, whose memory it takes";
  EXPECT_EQ(Since(before).idle, 0u);
}

// Through density control, a reset and the regulariser, with room for all, with too little now and
// then, and with too little in every step.
TEST_F(NoWait, StepsDoneAgainLeaveNoTrace) {
  TrainingRun run;
  run.settings.iterations = 40;
  run.settings.schedule.densify_every = 15;
  run.settings.schedule.opacity_reset_every = 35;
  run.settings.scale_regularizer = {0.5f, 0.01f, 1.2f};
  const int steps = 40;
  const test::Training room = RunOn(run, WithMargin(8), steps);
  EXPECT_NE(room.state.gaussians.size(), run.first.size());
  size_t idle[2];
  for (const bool always : {false, true}) {
    const Waits before = cuda_on_host::WaitsSoFar();
    const test::Training scant = RunOn(run, WithMargin(always ? 0.5 : 1), steps);
    idle[always] = Since(before).idle;
    EXPECT_EQ(scant.losses, room.losses);
    EXPECT_TRUE(test::SameBits(scant.state, room.state));
  }
  EXPECT_GT(idle[0], size_t(steps) / 2) << "some were done again";
  EXPECT_GT(idle[1], 2 * size_t(steps)) << "all were";
}

TEST_F(NoWait, MasksThatAreLearnedAreToo) {
  for (const char* rule : {"compact", "lp"}) {
    TrainingRun run;
    run.settings.iterations = 33;  // LP learns in the 22nd
    run.settings.prune.rule = rule;
    run.settings.prune.mask_weight = 0.5f;
    const test::Training room = RunOn(run, WithMargin(8), 24),
                         scant = RunOn(run, WithMargin(0.5), 24);
    EXPECT_EQ(scant.losses, room.losses) << rule;
    EXPECT_TRUE(test::SameBits(scant.state, room.state)) << rule;
  }
}

// Played images expect the number of instances of the last one.
TEST_F(NoWait, AnImageIsWaitedForOnce) {
  const TrainingRun run;
  const auto renderer = SceneRendererOn(Device::kCuda)(run.first);
  Camera camera = run.frames[0].camera;
  const int width = camera.width;
  std::unique_ptr<DeviceImage> image;
  const auto waits_of = [&](int of_width) {
    camera.width = of_width;
    const Waits before = cuda_on_host::WaitsSoFar();
    renderer->DrawToStay(camera, {}, AlphaMode::kOpaque, image);
    return Since(before).all;
  };
  EXPECT_EQ(waits_of(width / 3), 2u) << "for the first one's number, and for it";
  EXPECT_EQ(waits_of(width / 3), 1u);
  EXPECT_GT(waits_of(width), 2u) << "more than expected: rendered again";
  EXPECT_EQ(waits_of(width), 1u);
  EXPECT_EQ(waits_of(width / 3), 1u);
  RenderedImage on_host;
  renderer->Draw(camera, {}, on_host);  // allocates
  const Waits before = cuda_on_host::WaitsSoFar();
  renderer->Draw(camera, {}, on_host);
  EXPECT_EQ(Since(before).all, 1u) << "for the image and its copy together";
}

TEST_F(NoWait, ForecastsGoByTheFrameAndByGrowth) {
  InstanceForecast forecast(1);
  EXPECT_FALSE(forecast.Knows());
  forecast.Saw(1, 10, 200);
  forecast.Saw(0, 10, 100);
  EXPECT_EQ(forecast.Of(0, 10), 101u);
  EXPECT_EQ(forecast.Of(0, 20), 201u) << "in proportion to the Gaussians";
  EXPECT_EQ(forecast.Of(5, 10), 201u) << "the fullest, for a frame that was not drawn yet";
  forecast.Saw(0, 10, 150);
  EXPECT_EQ(forecast.Of(1, 10), 301u) << "frames grow together";
  for (int i = 0; i < 200; ++i) forecast.Saw(0, 10, 150);
  EXPECT_EQ(forecast.Of(1, 10), 201u);
  EXPECT_EQ(InstanceForecast(1.5).Of(0, 10), 1u);
}

}  // namespace
}  // namespace cosplat
