// The threads that stand in for oneTBB in the lean and the web build: cmake/lean/tbb.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

namespace cosplat::test {
namespace {

using std::chrono::microseconds;

// Every index once, in loops that follow each other at once, after the threads have fallen asleep,
// and while they do.
TEST(LeanPool, DoesEachIndexOnceHoweverLongTheThreadsWaited) {
  tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 4);
  std::vector<int> done(100);
  for (int loop = 0; loop < 2000; ++loop) {
    tbb::parallel_for(size_t(0), done.size(), [&](size_t i) { ++done[i]; });
    ASSERT_EQ(std::count(done.begin(), done.end(), loop + 1), long(done.size())) << loop;
    if (loop % 20 == 0) std::this_thread::sleep_for(microseconds(40 + loop % 7 * 5));
  }
}

TEST(LeanPool, UsesSeveralThreadsAndNoneForLoopsWithinLoops) {
  tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 4);
  std::mutex mutex;
  std::set<std::thread::id> outer, beside;
  tbb::parallel_for(0, 4, [&](int) {
    const std::thread::id self = std::this_thread::get_id();
    std::this_thread::sleep_for(microseconds(20000));
    tbb::parallel_for(0, 4, [&](int) {
      std::lock_guard lock(mutex);
      if (std::this_thread::get_id() != self) beside.insert(self);
    });
    std::lock_guard lock(mutex);
    outer.insert(self);
  });
  EXPECT_GT(outer.size(), 1u);
  EXPECT_TRUE(beside.empty());
}

// Whoever finds the pool taken works alone.
TEST(LeanPool, ServesSeveralCallers) {
  tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 4);
  std::vector<std::thread> callers;
  std::vector<int> sums(4, 0);
  for (size_t c = 0; c < sums.size(); ++c)
    callers.emplace_back([&, c] {
      for (int loop = 0; loop < 500; ++loop) {
        std::atomic<int> sum{0};
        tbb::parallel_for(0, 10, [&](int i) { sum += i; });
        sums[c] += sum;
      }
    });
  for (std::thread& caller : callers) caller.join();
  for (const int sum : sums) EXPECT_EQ(sum, 500 * 45);
}

}  // namespace
}  // namespace cosplat::test
