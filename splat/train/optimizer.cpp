#include "splat/train/optimizer.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "splat/math/adam.h"
#include "splat/train/cpu/adam_runs.h"

namespace cosplat {

namespace {

constexpr size_t kLongestRun = 512;  // Gaussians
constexpr size_t kRunsPerTask = 4;   // at least

std::array<AdamArray, kAttributeCount> ArraysOf(const AdamSettings& settings,
                                                const Gaussians* gradients,
                                                View<const float> position_rate_scale,
                                                Gaussians& values,
                                                AdamState& state) {
  std::array<AdamArray, kAttributeCount> arrays;
  for (int a = 0; a < kAttributeCount; ++a) {
    const math::AdamStep step = StepOf(settings, a, state.step);
    arrays[a].width = values.width(a);
    arrays[a].beta1 = step.beta1;
    arrays[a].beta2 = step.beta2;
    arrays[a].step_size = step.step_size;
    arrays[a].scaled_eps = step.scaled_eps;
    arrays[a].gradient = gradients ? gradients->values[a].data() : nullptr;
    arrays[a].value = values.values[a].data();
    arrays[a].m = state.m.values[a].data();
    arrays[a].v = state.v.values[a].data();
    arrays[a].rate_scale = a == kPosition ? position_rate_scale.data : nullptr;
  }
  return arrays;
}

// Appends group g, which is `behind` steps late, to the last run or to a new one.
void Append(size_t g, int behind, size_t count, std::vector<AdamRun>& runs) {
  const uint32_t begin = uint32_t(g * kGaussianGroup);
  const uint32_t end = uint32_t(std::min((g + 1) * kGaussianGroup, count));
  if (runs.empty() || runs.back().end != begin || runs.back().behind != behind ||
      end - runs.back().begin > kLongestRun)
    runs.push_back({begin, begin, behind});
  runs.back().end = end;
}

size_t Update(const std::array<AdamArray, kAttributeCount>& arrays,
              const std::vector<AdamRun>& runs) {
  std::atomic<size_t> bad{0};  // a count: the order of adding does not matter
  const auto update = [&](const auto& task) {
    for (const AdamArray& array : arrays)
      bad += AdamRuns(array, runs.data() + task.begin(), task.size());
  };
  // Isolated: a thread that waits here must not take up another trainer's step, whose runs would
  // overwrite these.
  tbb::this_task_arena::isolate(
      [&] { tbb::parallel_for(tbb::blocked_range<size_t>(0, runs.size(), kRunsPerTask), update); });
  return bad;
}

}  // namespace

math::AdamStep StepOf(const AdamSettings& settings, int attribute, int64_t step) {
  math::AdamStep s;
  const double correction1 = 1 - std::pow(double(s.beta1), double(step));
  const double correction2 = std::sqrt(1 - std::pow(double(s.beta2), double(step)));
  s.step_size = float(settings.rate[attribute] * correction2 / correction1);
  s.scaled_eps = float(settings.eps[attribute] * correction2);
  return s;
}

AdamState::AdamState(const Gaussians& gaussians)
    : m(gaussians.ZerosLike()),
      v(gaussians.ZerosLike()),
      updated(AdamGroupCount(gaussians.size()), 0) {}

size_t AdamStepAll(const AdamSettings& settings,
                   const Gaussians& gradients,
                   View<const float> position_rate_scale,
                   View<const uint32_t> groups,
                   Gaussians& values,
                   AdamState& state) {
  thread_local std::vector<AdamRun> runs;  // keeps its memory
  runs.clear();
  for (const uint32_t g : groups) {
    Append(g, int(state.step - state.updated[g]), values.size(), runs);
    state.updated[g] = state.step + 1;
  }
  ++state.step;
  return Update(ArraysOf(settings, &gradients, position_rate_scale, values, state), runs);
}

void AdamCatchUpAll(const AdamSettings& settings,
                    View<const float> position_rate_scale,
                    Gaussians& values,
                    AdamState& state) {
  std::vector<AdamRun> runs;
  for (size_t g = 0; g < state.updated.size(); ++g) {
    if (state.updated[g] == state.step) continue;
    Append(g, int(state.step - state.updated[g]), values.size(), runs);
    state.updated[g] = state.step;
  }
  Update(ArraysOf(settings, nullptr, position_rate_scale, values, state), runs);
}

}  // namespace cosplat
