// The loops of half_adam.h, compiled per instruction set.
#include "apps/study/bench/half_adam.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "apps/study/bench/measure.h"
#include "splat/base/rng.h"
#include "splat/device/buffer.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "apps/study/bench/half_adam.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/math/adam.h"

COSPLAT_MATH_BEGIN

// 32 random bits: the finaliser of MurmurHash3 (Appleby 2011) of the index, offset in each step by
// 2^32 over the golden ratio.
inline uint32_t HashOf(uint32_t index, uint32_t step) {
  uint32_t h = index + step * 0x9e3779b9u;
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  return h ^ (h >> 16);
}

inline float FromHalf(uint16_t half) { return std::bit_cast<float>(uint32_t(half) << 16); }

// `random` < 2^16. The probability of a carry into the upper half is the lower half / 2^16.
inline uint16_t ToHalf(float x, uint32_t random) {
  constexpr uint32_t kInfinity = 0x7f800000u, kQuiet = 0x00400000u;
  const uint32_t bits = std::bit_cast<uint32_t>(x);
  const bool is_nan = (bits & 0x7fffffffu) > kInfinity;
  // A NaN must neither overflow nor become an infinity by losing its lower half.
  return uint16_t((is_nan ? bits | kQuiet : bits + random) >> 16);
}

inline float Load(float x) { return x; }
inline float Load(uint16_t half) { return FromHalf(half); }
inline void Store(float m, float v, uint32_t, float& to_m, float& to_v) {
  to_m = m;
  to_v = v;
}
inline void Store(float m, float v, uint32_t hash, uint16_t& to_m, uint16_t& to_v) {
  to_m = ToHalf(m, hash & 0xffffu);
  to_v = ToHalf(v, hash >> 16);
}

// Indices have 32 bits, the same width as the lanes.
void RoundRange(
    uint32_t step, uint32_t begin, uint32_t end, float* __restrict m, float* __restrict v) {
  for (uint32_t i = begin; i < end; ++i) {
    uint16_t half_m, half_v;
    Store(m[i], v[i], HashOf(i, step), half_m, half_v);
    m[i] = FromHalf(half_m);
    v[i] = FromHalf(half_v);
  }
}

template <class Moment>
size_t Update(const MomentArray<Moment>& a, uint32_t step, uint32_t begin, uint32_t end) {
  const AdamStep adam{a.beta1, a.beta2, a.step_size, a.scaled_eps};
  const float* __restrict gradient = a.gradient;
  float* __restrict value = a.value;
  Moment* __restrict m = a.m, * __restrict v = a.v;
  unsigned bad = 0;
  for (uint32_t i = begin; i < end; ++i) {
    const bool usable = IsUsableGradient(gradient[i]);
    bad += !usable;
    float first = Load(m[i]), second = Load(v[i]);
    AdamUpdate(adam, usable ? gradient[i] : 0.0f, value[i], first, second);
    Store(first, second, HashOf(i, step), m[i], v[i]);
  }
  return bad;
}
// Named functions, as required by the dispatch.
size_t UpdateFloats(const MomentArray<float>& a, uint32_t step, uint32_t begin, uint32_t end) {
  return Update(a, step, begin, end);
}
size_t UpdateHalves(const MomentArray<uint16_t>& a, uint32_t step, uint32_t begin, uint32_t end) {
  return Update(a, step, begin, end);
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(RoundRange);
HWY_EXPORT(UpdateFloats);
HWY_EXPORT(UpdateHalves);
}  // namespace math

void RoundMoments(uint32_t step, uint32_t begin, uint32_t end, float* m, float* v) {
  using namespace math;
  HWY_DYNAMIC_DISPATCH(RoundRange)(step, begin, end, m, v);
}

size_t AdamRange(const MomentArray<float>& array, uint32_t step, uint32_t begin, uint32_t end) {
  using namespace math;
  return HWY_DYNAMIC_DISPATCH(UpdateFloats)(array, step, begin, end);
}
size_t AdamRange(const MomentArray<uint16_t>& array, uint32_t step, uint32_t begin, uint32_t end) {
  using namespace math;
  return HWY_DYNAMIC_DISPATCH(UpdateHalves)(array, step, begin, end);
}

namespace {

// Calls f(begin, end) on all threads; a task is about as large as one of the optimiser's.
template <class F>
void InTasks(uint32_t numbers, const F& f) {
  constexpr uint32_t kTask = 1 << 15;
  tbb::parallel_for(uint32_t(0), (numbers + kTask - 1) / kTask, [&](uint32_t task) {
    f(task * kTask, std::min((task + 1) * kTask, numbers));
  });
}

template <class Moment>
struct Loop {
  Buffer<float> gradient, value;
  Buffer<Moment> m, v;
  double best_ms = std::numeric_limits<double>::infinity();

  explicit Loop(uint32_t numbers) : gradient(numbers), value(numbers), m(numbers), v(numbers) {
    Rng rng{1};
    for (float& g : gradient) g = rng.Normal();
  }
  // The values of the constants do not matter, as long as nothing overflows.
  void Run(uint32_t step) {
    const MomentArray<Moment> array{
        0.9f, 0.999f, 1e-6f, 1e-15f, gradient.data(), value.data(), m.data(), v.data()};
    const auto start = std::chrono::steady_clock::now();
    InTasks(uint32_t(gradient.size()),
            [&](uint32_t begin, uint32_t end) { AdamRange(array, step, begin, end); });
    best_ms = std::min(best_ms, 1e3 * SecondsSince(start));
  }
};

}  // namespace

AdamLoopTimes TimeAdamLoops(uint32_t numbers, int batches) {
  Loop<float> floats(numbers);
  Loop<uint16_t> halves(numbers);
  // Evicts the caches, as the rest of a training step does: 96 MiB exceed the caches of two cores.
  Buffer<float> other(size_t(96) << 18);
  const auto clear_caches = [&] {
    InTasks(uint32_t(other.size()), [&](uint32_t begin, uint32_t end) {
      for (uint32_t i = begin; i < end; ++i) other[i] += 1;
    });
  };
  // Alternately, so that other load on the machine affects both.
  for (int batch = 0; batch < batches; ++batch) {
    clear_caches();
    floats.Run(uint32_t(batch));
    clear_caches();
    halves.Run(uint32_t(batch));
  }
  return {floats.best_ms, halves.best_ms};
}

}  // namespace cosplat
#endif
