// FmaPeakGflops, compiled per instruction set.
#include <algorithm>

#include "apps/study/bench/machine.h"
#include "apps/study/bench/measure.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "apps/study/bench/fma_peak.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace cosplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Independent chains: two units times a latency of up to six cycles; the chains and their two
// factors fit into the sixteen registers of AVX2.
constexpr int kChains = 12;

// Returns the number of operations. `sink`: [kChains lanes], prevents elimination of the loop.
double MultiplyAdd(int rounds, float* sink) {
  const hn::ScalableTag<float> d;
  const auto scale = hn::Set(d, 0.999f), offset = hn::Set(d, 1e-3f);
  hn::Vec<decltype(d)> chains[kChains];
  for (int k = 0; k < kChains; ++k) chains[k] = hn::Set(d, float(k));
  for (int i = 0; i < rounds; ++i)
    for (int k = 0; k < kChains; ++k) chains[k] = hn::MulAdd(chains[k], scale, offset);
  for (int k = 0; k < kChains; ++k) sink[k] += hn::GetLane(hn::SumOfLanes(d, chains[k]));
  return 2.0 * double(hn::Lanes(d)) * kChains * rounds;
}

}  // namespace cosplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cosplat {

HWY_EXPORT(MultiplyAdd);

double FmaPeakGflops(int batches) {
  constexpr int kRounds = 200000;
  float sink[16] = {};
  double operations = 0;
  const double seconds = FastestSeconds(
      batches, 1, [&] { operations = HWY_DYNAMIC_DISPATCH(MultiplyAdd)(kRounds, sink); });
  volatile float keep = *std::max_element(sink, sink + 16);
  (void)keep;
  return 1e-9 * operations / seconds;
}

}  // namespace cosplat
#endif
