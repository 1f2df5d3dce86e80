// A training step in a steady state allocates nothing: neither in the trainer nor in what it calls;
// and what a run holds is what it says and little enough.
// An executable of its own, because it counts every `operator new` of the process.
#include <gtest/gtest.h>
#include <malloc.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"

namespace {

std::atomic<size_t> allocations{0};
std::atomic<size_t> live_bytes{0};

void* Allocate(size_t size, size_t alignment) {
  ++allocations;
  // aligned_alloc wants a multiple of the alignment.
  void* p = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  live_bytes += malloc_usable_size(p);
  return p;
}
void Free(void* p) {
  live_bytes -= malloc_usable_size(p);  // of null: 0
  std::free(p);
}

}  // namespace

void* operator new(size_t size) { return Allocate(size, alignof(std::max_align_t)); }
void* operator new[](size_t size) { return Allocate(size, alignof(std::max_align_t)); }
void* operator new(size_t size, std::align_val_t alignment) {
  return Allocate(size, size_t(alignment));
}
void* operator new[](size_t size, std::align_val_t alignment) {
  return Allocate(size, size_t(alignment));
}
void operator delete(void* p) noexcept { Free(p); }
void operator delete[](void* p) noexcept { Free(p); }
void operator delete(void* p, size_t) noexcept { Free(p); }
void operator delete[](void* p, size_t) noexcept { Free(p); }
void operator delete(void* p, std::align_val_t) noexcept { Free(p); }
void operator delete[](void* p, std::align_val_t) noexcept { Free(p); }
void operator delete(void* p, size_t, std::align_val_t) noexcept { Free(p); }
void operator delete[](void* p, size_t, std::align_val_t) noexcept { Free(p); }

namespace cosplat {
namespace {

using namespace test;

TEST(Allocation, NoneInASteadyStep) {
  // One thread: which of several makes its scratch when is for the scheduler to say.
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  constexpr size_t kFrames = 5;
  SceneSubject subject(TargetImages(TrueScene(2), Ring(kFrames, 2.2f), true), 1);
  TrainSettings settings = ShortRun(1000, 2);
  settings.background = Background::kRandom;
  settings.scale_regularizer.weight = 0.1f;
  settings.schedule.densify_from = 1000;          // a steady state: no change in number
  settings.schedule.opacity_reset_every = 10000;  // nor, with rates of 0, of what a view draws
  settings.rates = {0, 0, 0, 1, 0, 0, 0};
  Trainer trainer(settings, subject, FirstGaussians(5000, 2));
  for (size_t i = 0; i < 4 * kFrames; ++i) trainer.Step();
  ASSERT_GT(allocations, 0u);  // they are counted
  for (size_t i = 0; i < 3 * kFrames; ++i) {
    const size_t before = allocations;
    trainer.Step();
    EXPECT_EQ(allocations - before, 0u) << "step " << i;
  }
}

// 1,300 B: a bound of ours; 944 of them are parameters, gradient and two moments. What is not told
// (scratch of threads, a list of frames) is less than 5 %: measured, 0.1 %.
TEST(Allocation, TheTrainerHoldsWhatItSays) {
  constexpr size_t kFirst = 20000;
  SceneSubject subject(TargetImages(TrueScene(3), Ring(5, 2.2f)), 1);
  TrainSettings settings = ShortRun(100, 3);
  settings.density.max_count = 30000;
  settings.density.gradient_threshold = 1e-7f;  // asks for more than that
  const size_t before = live_bytes;
  Trainer trainer(settings, subject, FirstGaussians(kFirst, 3));
  for (int i = 0; i < settings.iterations; ++i) trainer.Step();
  const double held = double(live_bytes - before), count = double(trainer.state().gaussians.size());
  ASSERT_GT(count, kFirst);  // there was density control
  double all = 0;
  for (const MemoryPart& part : trainer.Memory()) all += double(part.bytes);
  const double of_gaussians = double(SumOf(trainer.Memory(), MemoryOf::kGaussians));
  EXPECT_NEAR(all, held, 0.05 * held);
  EXPECT_LE(of_gaussians / count, 1300);
}

}  // namespace
}  // namespace cosplat
