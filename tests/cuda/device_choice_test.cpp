// What --device chooses, where there is a device and the build has its back end.
#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include "splat/train/step/step_engine.h"
#include "tests/parity/training_run.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

TEST(DeviceChoice, TakesTheGpuIfThereIsOne) {
  EXPECT_EQ(UsableDevice(Device::kCpu), Device::kCpu);
  EXPECT_EQ(UsableDevice(Device::kCuda), Device::kCuda);
  EXPECT_EQ(UsableDevice({}), Device::kCuda);
  EXPECT_EQ(NameOf(Device::kCuda), "the host, pretending");
  EXPECT_EQ(NameOf(Device::kCpu), "CPU");
}

TEST(DeviceChoice, SaysWhyThereIsNone) {
  struct Case {
    int problem, driver;
    const char* text;
  };
  for (const Case& c :
       {Case{cudaErrorInsufficientDriver, 12020, "supports CUDA 12.2, this program needs 13.0"},
        Case{cudaErrorInsufficientDriver, 0, "no CUDA device was found"},
        Case{cudaErrorNoDevice, 13000, "no CUDA device was found"},
        Case{cudaErrorInvalidValue, 13000, "invalid argument"}}) {
    cuda_on_host::SetDriver(c.problem, c.driver);
    test::ExpectError([] { UsableDevice(Device::kCuda); }, {"--device", c.text});
    EXPECT_EQ(UsableDevice({}), Device::kCpu);
  }
  cuda_on_host::SetDriver(0, 13000);
  EXPECT_EQ(UsableDevice({}), Device::kCuda);
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
