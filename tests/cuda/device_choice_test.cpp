// What --device chooses, where there is a device and the build has its back end.
#include <gtest/gtest.h>

#include "splat/train/cuda/device_step_engine.h"
#include "splat/train/train_device.h"
#include "tests/parity/training_run.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

TEST(DeviceChoice, TakesTheCardWhereThereIsOne) {
  EXPECT_EQ(DeviceFromString("cpu"), Device::kCpu);
  EXPECT_EQ(DeviceFromString("cuda"), Device::kCuda);
  EXPECT_EQ(DeviceFromString("auto"), Device::kCuda);
  EXPECT_EQ(NameOf(Device::kCuda), "the host, pretending");
  EXPECT_EQ(NameOf(Device::kCpu), "CPU");
  test::ExpectError([] { DeviceFromString("gpu"); }, {"--device", "auto, cpu, cuda"});
}

TEST(DeviceChoice, MakesWhatWorksThere) {
  const test::TrainingRun run;
  SceneSubject subject(run.frames, 1);
  for (const Device device : {Device::kCpu, Device::kCuda}) {
    TrainingState state;
    state.gaussians = run.first;
    state.adam = AdamState(run.first);
    state.statistics.Reset(run.first.size());
    const auto engine = StepEngineOn(device, true)(run.settings, subject, state);
    EXPECT_EQ(dynamic_cast<cuda::DeviceStepEngine*>(engine.get()) != nullptr,
              device == Device::kCuda);
    EXPECT_EQ(engine->count(), run.first.size());
    const auto rasterizer = MakeRasterizer(device);
    const auto tape = rasterizer->MakeTape();
    RenderedImage image;
    rasterizer->Forward(
        ViewOf(run.first), run.first.basis, run.frames[0].camera, {{0, 0, 0}, 1}, image, *tape);
    EXPECT_GT(tape->visible_count(), 0u);
  }
}

}  // namespace
}  // namespace cosplat
