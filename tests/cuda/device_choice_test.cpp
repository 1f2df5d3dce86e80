// What --device chooses, where there is a device and the build has its back end.
#include <gtest/gtest.h>

#include "splat/train/step_engine.h"
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
  test::ExpectError([] { DeviceFromString("gpu"); }, {"--device", "auto, cpu or cuda"});
}

// Knows where it is trained.
struct Placed : SceneSubject {
  using SceneSubject::SceneSubject;
  void WorkIn(Stream& stream) override { on_host = stream.on_host(); }
  bool on_host = true;
};

TEST(DeviceChoice, MakesWhatWorksThere) {
  const test::TrainingRun run;
  Placed subject(run.frames, 1);
  for (const Device device : {Device::kCpu, Device::kCuda}) {
    TrainingState state;
    state.gaussians = run.first;
    state.adam = AdamState(run.first);
    state.statistics.Reset(run.first.size());
    const auto engine = StepEngineOn(device, true)(run.settings, subject, state);
    EXPECT_EQ(subject.on_host, device == Device::kCpu);
    EXPECT_EQ(engine->count(), run.first.size());
    const auto rasterizer = MakeRasterizer(device);
    const auto tape = rasterizer->MakeTape();
    RenderedImage image;
    rasterizer->Forward(
        ViewOf(run.first), run.first.basis, run.frames[0].camera, {{0, 0, 0}, 1}, image, *tape);
    EXPECT_GT(tape->counts()->visible, 0u);
  }
}

}  // namespace
}  // namespace cosplat
