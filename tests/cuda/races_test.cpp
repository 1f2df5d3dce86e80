// Races between the threads of the CUDA kernels, found by the thread sanitizer on the emulated
// device (tests/support/cuda_on_host/races.h).
#include <gtest/gtest.h>

#include <thread>

#include "splat/device/buffer.h"
#include "splat/device/cuda/launch.cuh"
#include "splat/device/cuda/stream.h"
#include "splat/train/step/step_engine.h"
#include "splat/train/subject/scene_subject.h"
#include "tests/parity/parity_case.h"
#include "tests/support/device_step.h"

namespace {
int reports = 0;
}
// Called by the sanitizer for each race that it finds, which it must not look for here.
extern "C" __attribute__((no_sanitize("thread"))) void __tsan_on_report(void*) { ++reports; }
// Races are counted here, each time: the planted ones, which are of one place, must be seen and
// must not fail the program. TSAN_OPTIONS=symbolize=1 names lines, slowly.
extern "C" const char* __tsan_default_options() {
  return "exitcode=0:suppress_equal_addresses=0:suppress_equal_stacks=0:symbolize=0";
}

namespace cosplat {
namespace {

template <class F>
struct InBlock {
  static constexpr unsigned kThreads = 64;
  F f;
  void operator()() const { f(); }
};

// Races found while two blocks of two warps run f.
template <class F>
int RacesIn(const F& f) {
  const int before = reports;
  cuda::CudaStream stream;
  cuda::ForBlocks(2, stream, InBlock<F>{f});
  stream.Wait();
  return reports - before;
}

// One thread writes and another adds: of the other warp, or of the same.
TEST(Races, OfABlockAreFoundAndBarriersEndThem) {
  EXPECT_GT(RacesIn([] {
              unsigned& slot = cuda::SharedMemory<unsigned>();
              if (threadIdx.x == 0) slot = 1;
              if (threadIdx.x == 40) slot += 1;
            }),
            0);
  EXPECT_EQ(RacesIn([] {
              unsigned& slot = cuda::SharedMemory<unsigned>();
              if (threadIdx.x == 0) slot = 1;
              __syncthreads();
              if (threadIdx.x == 40) slot += 1;
            }),
            0);
}

TEST(Races, OfAWarpAreEndedBySyncwarpAlone) {
  EXPECT_GT(RacesIn([] {
              unsigned& slot = cuda::SharedMemory<unsigned>();
              if (threadIdx.x == 0) slot = 1;
              __ballot_sync(cuda::kAllLanes, 1);  // orders no memory
              if (threadIdx.x == 1) slot += 1;
            }),
            0);
  EXPECT_EQ(RacesIn([] {
              unsigned& slot = cuda::SharedMemory<unsigned>();
              if (threadIdx.x == 0) slot = 1;
              __syncwarp();
              if (threadIdx.x == 1) slot += 1;
            }),
            0);
}

TEST(Races, BetweenBlocksAreFoundAndAtomicsAreNone) {
  cuda::CudaStream stream;
  Buffer<unsigned> sum;
  sum.Refill(1, stream);
  unsigned* const p = sum.data();
  EXPECT_GT(RacesIn([p] {
              if (threadIdx.x == 0) *p = blockIdx.x;
            }),
            0);
  EXPECT_EQ(RacesIn([p] { atomicAdd(p, 1u); }), 0);
}

TEST(Races, NoneWhereThreadsProvideTheSameKernels) {
  const int before = reports;
  std::thread other(cuda::ProvideTrainKernels);
  cuda::ProvideTrainKernels();
  other.join();
  EXPECT_EQ(reports, before);
}

TEST(Races, NoneInAStep) {
  const int before = reports;
  for (const cuda::SumOrder order : {cuda::SumOrder::kAny, cuda::SumOrder::kFixed}) {
    test::ParityCase c = test::RandomCase("races", 150, 40, 24, Basis::kDcsh, 1);
    // One that covers all tiles: counted and stored by a whole warp.
    for (int k = 0; k < 3; ++k) c.gaussians.at(kScaleLog, 9)[k] = 1;
    const Image8 photograph(c.camera.width, c.camera.height, 3, 90);
    AdamSettings rates;
    rates.rate.fill(1e-3f);
    test::DeviceStep step(c.gaussians, c.camera, photograph, c.settings, rates, order);
    for (int s = 0; s < 2; ++s) {  // the second waits for nothing
      step.Run();
      EXPECT_TRUE(step.Settle());
    }
    Buffer<Contribution> contributions;
    step.rasterizer.Contributions(step.image, step.tape, contributions);
    step.stream().Wait();
    EXPECT_GT(step.counts.instances, 200u);
  }
  EXPECT_EQ(reports, before);
}

TEST(Races, NoneInTraining) {
  const int before = reports;
  const test::ParityCase c = test::RandomCase("races", 150, 40, 24, Basis::kDcsh, 1);
  SceneSubject subject({{c.camera, Image8(c.camera.width, c.camera.height, 3, 90)}}, 1);
  TrainSettings settings;
  settings.scale_regularizer = {0.1f, 0.01f, 1.1f};
  TrainingState state;
  state.gaussians = c.gaussians;
  state.adam = AdamState(c.gaussians);
  state.statistics.Reset(c.gaussians.size());
  cuda::ProvideTrainKernels();
  StepEngine engine(
      settings,
      subject,
      state,
      {std::make_unique<cuda::CudaRasterizer>(cuda::SumOrder::kFixed), cuda::MakeCudaLoss()});
  StepPlan plan{1, 0, c.settings, {}, true};
  plan.rates.rate.fill(1e-3f);
  engine.Step({&plan, 1});
  plan.iteration = 2;
  engine.Step({&plan, 1});  // the first that waits for nothing
  engine.CatchUp(plan.rates);
  DensitySettings density;
  density.gradient_threshold = 0;
  density.max_count = 200;
  engine.ControlDensity(density, true);
  engine.SortInSpace();
  engine.ResetOpacity();
  const std::vector<uint32_t> frames{0};
  EXPECT_EQ(engine.Contributions({frames, 1, {0, 0, 0}, 1}).size(), engine.count());
  engine.Fetch();
  EXPECT_EQ(reports, before);
}

}  // namespace
}  // namespace cosplat
