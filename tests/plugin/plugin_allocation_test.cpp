// A render allocates nothing after the first: an executable of its own, because it counts every
// `operator new` of the process, libcosplat.so's included.
#include <tbb/global_control.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/plugin/plugin_fixture.h"
#include "tests/plugin/restless_sequence.h"
#include "tests/support/restless_params.h"

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

namespace cosplat::test {
namespace {

TEST(PluginAllocation, NoneAfterTheFirstFrame) {
  // One thread: which of several makes its scratch when is for the scheduler to say.
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  PluginFiles::Get();
  const size_t before_open = allocations;
  const OpenAvatar avatar;
  ASSERT_GT(allocations - before_open, 100u);  // those of libcosplat.so are counted
  std::vector<uint8_t> bytes;
  cosplat_picture picture = PictureInto(bytes, 100, 100);
  std::vector<float> depth(100 * 100);
  picture.depth = depth.data();
  cosplat_camera camera = SetOrbit(avatar, 100, 100, 0);
  ASSERT_EQ(cosplat_render(avatar, &picture), COSPLAT_OK);
  for (int frame = 0; frame < 30; ++frame) {
    const FlameParams params = RestlessParams(PluginFiles::Get().flame, frame);
    const cosplat_parameters set = ParametersOf(params, frame);
    const size_t before = allocations;
    ASSERT_EQ(cosplat_set_parameters(avatar, &set), COSPLAT_OK);
    ASSERT_EQ(cosplat_orbit_camera(avatar, 100, 100, 0.01f * float(frame), 0, 1, &camera),
              COSPLAT_OK);
    ASSERT_EQ(cosplat_set_camera(avatar, &camera), COSPLAT_OK);
    picture.alpha = uint32_t(frame % 3);
    ASSERT_EQ(cosplat_render(avatar, &picture), COSPLAT_OK);
    EXPECT_EQ(allocations - before, 0u) << "frame " << frame;
  }
}

// Held, gone to rest, come back and smoothed, by frames that are set and by those of a drive.
TEST(PluginAllocation, NoneWhileTimeGoesOn) {
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  const OpenAvatar avatar;
  cosplat_policy policy = Zeroed<cosplat_policy>();
  policy.smoothing = COSPLAT_SMOOTHING_ONE_EURO;
  policy.loop = 1;
  ASSERT_EQ(cosplat_set_policy(avatar, &policy), COSPLAT_OK);
  ASSERT_EQ(cosplat_set_drive(avatar, WriteSequence("loop.npz", 5).c_str()), COSPLAT_OK);
  std::vector<uint8_t> bytes;
  const cosplat_picture picture = PictureInto(bytes, 64, 64);
  for (int frame = 0; frame < 60; ++frame) {
    const int64_t now_ns = frame * int64_t(40'000'000);
    const FlameParams params = RestlessParams(PluginFiles::Get().flame, frame);
    const cosplat_parameters set = ParametersOf(params, now_ns);
    const size_t before = allocations;
    if (frame >= 50) {
      ASSERT_EQ(cosplat_set_parameters(avatar, &set), COSPLAT_OK);
    }
    ASSERT_EQ(cosplat_advance(avatar, now_ns), COSPLAT_OK);
    ASSERT_EQ(cosplat_render(avatar, &picture), COSPLAT_OK);
    if (frame > 0) {
      EXPECT_EQ(allocations - before, 0u) << "frame " << frame;
    }
    if (frame == 10) cosplat_set_drive(avatar, nullptr);  // rest from frame 42 on
  }
}

}  // namespace
}  // namespace cosplat::test
