// The emulated device itself: what it computes, and what it finds.
#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/device/cuda/launch.cuh"
#include "splat/device/cuda/stream.h"
#include "tests/support/expect_error.h"

namespace cosplat::cuda {
namespace {

using cuda_on_host::Fault;

struct Emulation : testing::Test {
  void SetUp() override { cuda_on_host::SetSchedule(1); }
  CudaStream stream;
};

// A body for a whole block.
template <unsigned kBlockThreads, class F>
struct InBlock {
  static constexpr unsigned kThreads = kBlockThreads;
  F f;
  void operator()() const { f(); }
};
template <unsigned kThreads, class F>
void RunBlocks(size_t blocks, Stream& stream, const F& f) {
  ForBlocks(blocks, stream, InBlock<kThreads, F>{f});
  stream.Wait();
}

std::string FaultOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Fault& fault) {
    return fault.what();
  }
  return "";
}

TEST_F(Emulation, EveryThreadRunsOnce) {
  std::vector<int> runs(1000, 0);
  ForEachThread(runs.size(), stream, [&runs](size_t i) { ++runs[i]; });
  EXPECT_EQ(runs[0], 0) << "before the host waits, nothing is done";
  stream.Wait();
  EXPECT_EQ(runs, std::vector<int>(1000, 1));
}

TEST_F(Emulation, AnEventIsWaitedForAlone) {
  int before = 0, after = 0;
  const Event event;
  event.Wait();  // never recorded
  ForEachThread(1, stream, [&before](size_t) { ++before; });
  Event recorded;
  recorded.Record(stream);
  ForEachThread(1, stream, [&after](size_t) { ++after; });
  const cuda_on_host::Waits waits = cuda_on_host::WaitsSoFar();
  recorded.Wait();
  EXPECT_EQ(before, 1);
  EXPECT_EQ(after, 0);
  recorded.Wait();
  EXPECT_EQ(cuda_on_host::WaitsSoFar().all, waits.all + 1);
  EXPECT_EQ(cuda_on_host::WaitsSoFar().idle, waits.idle);
  stream.Wait();
  EXPECT_EQ(after, 1);
  EXPECT_EQ(cuda_on_host::WaitsSoFar().idle, waits.idle + 1);
}

TEST_F(Emulation, WarpsExchange) {
  RunBlocks<64>(1, stream, [] {
    const int lane = int(Lane());
    EXPECT_EQ(__shfl_up_sync(kAllLanes, lane, 3), lane < 3 ? lane : lane - 3);
    EXPECT_EQ(__shfl_down_sync(kAllLanes, 2.5f * lane, 1), 2.5f * (lane < 31 ? lane + 1 : lane));
    EXPECT_EQ(__shfl_sync(kAllLanes, lane, 7), 7);
    EXPECT_EQ(__ballot_sync(kAllLanes, lane % 2), 0xaaaaaaaau);
    EXPECT_EQ(__any_sync(kAllLanes, lane == 40), 0);
    EXPECT_EQ(__syncthreads_count(threadIdx.x < 40), 40);
  });
}

TEST_F(Emulation, OrdersDifferBetweenSeeds) {
  std::set<std::vector<unsigned>> orders;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    cuda_on_host::SetSchedule(seed);
    std::vector<unsigned> order;
    RunBlocks<32>(4, stream, [&order] { order.push_back(blockIdx.x * 32 + threadIdx.x); });
    orders.insert(order);
  }
  EXPECT_EQ(orders.size(), 4u);
}

TEST_F(Emulation, SharedMemoryIsNanInEveryBlock) {
  int nans = 0;
  RunBlocks<32>(3, stream, [&nans] {
    float& x = SharedMemory<float>();
    if (threadIdx.x == 0) {
      nans += x != x;
      x = 1;
    }
  });
  EXPECT_EQ(nans, 3);
}

// A barrier is missing: what a thread reads depends on who came first.
TEST_F(Emulation, RacesShow) {
  int missed = 0;
  RunBlocks<64>(1, stream, [&missed] {
    struct Slots {
      unsigned of[64];
    };
    Slots& slots = SharedMemory<Slots>();
    slots.of[threadIdx.x] = threadIdx.x;
    missed += slots.of[63 - threadIdx.x] != 63 - threadIdx.x;
  });
  EXPECT_GT(missed, 0);
}

TEST_F(Emulation, FindsMeetingsThatNotAllReach) {
  const std::string missing = FaultOf([&] {
    RunBlocks<64>(1, stream, [] {
      if (threadIdx.x < 40) __syncthreads();
    });
  });
  EXPECT_NE(missing.find("40 threads wait"), std::string::npos) << missing;
  const std::string elsewhere = FaultOf([&] {
    RunBlocks<32>(1, stream, [] {
      if (Lane() < 7)
        __syncwarp();
      else
        __ballot_sync(kAllLanes, 1);
    });
  });
  EXPECT_NE(elsewhere.find("threads meet at"), std::string::npos) << elsewhere;
  const std::string part = FaultOf([&] { RunBlocks<32>(1, stream, [] { __syncwarp(0xffu); }); });
  EXPECT_NE(part.find("a part"), std::string::npos) << part;
}

TEST_F(Emulation, MemoryIsTheDevicesAlone) {
  Buffer<float> buffer;
  buffer.Refill(64, stream);
  float first = 0;
  Readback<float> readback(stream);
  first = readback.Get(buffer.data(), stream);
  EXPECT_NE(first, first) << "new memory is NaN";
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  EXPECT_DEATH({ *const_cast<volatile float*>(buffer.data()) = 1; }, "");
  const View<float> view = buffer.view();
  EXPECT_DEATH(
      {
        ForEachThread(65, stream, [view](size_t i) { view[i] = 0; });
        stream.Wait();
      },
      "i < count");
  float* const data = buffer.data();
  const size_t beyond = buffer.capacity();
  EXPECT_DEATH(
      {
        ForEachThread(1, stream, [=](size_t) { data[beyond] = 0; });
        stream.Wait();
      },
      "");
}

TEST_F(Emulation, RefusesWhatDoesNotFit) {
  const size_t before = cuda_on_host::FreeMemory();
  cuda_on_host::SetFreeMemory(1000);
  Buffer<float> buffer;
  test::ExpectError([&] { buffer.Refill(2000, stream); },
                    {"CUDA", "out of device memory: 0.0 MB requested", " free"});
  cuda_on_host::SetFreeMemory(before);
  EXPECT_TRUE(buffer.empty());
  buffer.Refill(2000, stream);
  EXPECT_EQ(buffer.size(), 2000u);
}

}  // namespace
}  // namespace cosplat::cuda
