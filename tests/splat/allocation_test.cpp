// A training step in a steady state allocates nothing: neither in the trainer nor in what it calls.
// An executable of its own, because it counts every `operator new` of the process.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/splat/training_fixture.h"

namespace {

std::atomic<size_t> allocations{0};

void* Allocate(size_t size, size_t alignment) {
  ++allocations;
  // aligned_alloc wants a multiple of the alignment.
  void* p = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
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
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, size_t) noexcept { std::free(p); }
void operator delete[](void* p, size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, size_t, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, size_t, std::align_val_t) noexcept { std::free(p); }

namespace cosplat {
namespace {

using namespace test;

TEST(Allocation, NoneInASteadyStep) {
  // One thread: which of several makes its scratch when is for the scheduler to say.
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  constexpr size_t kFrames = 5;
  SceneSubject subject(Photographs(TrueScene(2), Ring(kFrames, 2.2f), true), 1);
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

}  // namespace
}  // namespace cosplat
