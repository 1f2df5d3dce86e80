#include "splat/train/optimize/optimizer.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "splat/device/for_each.h"
#include "splat/train/optimize/cpu/adam_runs.h"
#include "splat/train/optimize/kernels/adam.h"

namespace cosplat {

namespace {

constexpr size_t kRowsPerRun = 512;
constexpr size_t kRunsPerTask = 4;  // at least

void Update(const AdamSettings& settings,
            const Gaussians* gradients,
            View<const float> position_rate_scale,
            Gaussians& values,
            AdamState& state,
            Stream& stream) {
  UpdateNumbers kernel{{}, std::as_const(state.behind).view(), state.ignored.data()};
  size_t max = 0;
  for (int a = 0; a < kAttributeCount; ++a) {
    AdamArray& array = kernel.attributes[a];
    const math::AdamStep step =
        math::AdamStepAt(settings.rate[a], settings.eps[a], state.step, settings.batch);
    array.beta1 = step.beta1;
    array.beta2 = step.beta2;
    array.step_size = step.step_size;
    array.scaled_eps = step.scaled_eps;
    array.numbers = values.values[a].size();
    array.width = std::max(values.width(a), 1);
    array.gradient = gradients ? gradients->values[a].data() : nullptr;
    array.value = values.values[a].data();
    array.m = state.m.values[a].data();
    array.v = state.v.values[a].data();
    array.rate_scale =
        a == kPosition && !position_rate_scale.empty() ? position_rate_scale.data : nullptr;
    max = std::max(max, array.numbers);
  }
  ForEachRow(max, stream, kernel);
}

// Appends group g, which is `behind` steps behind, to the last run or to a new one.
void Append(size_t g, int behind, size_t count, std::vector<AdamRun>& runs) {
  const uint32_t begin = uint32_t(g * kGaussianGroup);
  const uint32_t end = uint32_t(std::min((g + 1) * kGaussianGroup, count));
  if (runs.empty() || runs.back().end != begin || runs.back().behind != behind ||
      end - runs.back().begin > kRowsPerRun)
    runs.push_back({begin, begin, behind});
  runs.back().end = end;
}

}  // namespace

void RunOnHost(size_t, const UpdateNumbers& kernel) {
  thread_local std::vector<AdamRun> runs;  // reuses its memory
  runs.clear();
  const size_t count = kernel.attributes[kOpacityLogit].numbers;
  for (size_t g = 0; g < kernel.behind.size(); ++g) {
    const uint32_t behind = kernel.behind[g];
    if (behind != kNotNow) Append(g, int(behind), count, runs);
  }
  std::atomic<uint32_t> bad{0};  // a count: the order of adding does not matter
  const auto update = [&, all = runs.data()](const auto& task) {
    for (const AdamArray& array : kernel.attributes)
      if (array.numbers != 0) bad += uint32_t(AdamRuns(array, all + task.begin(), task.size()));
  };
  // Isolated: a thread that waits here must not pick up another trainer's step, which would
  // overwrite its runs.
  tbb::this_task_arena::isolate(
      [&] { tbb::parallel_for(tbb::blocked_range<size_t>(0, runs.size(), kRunsPerTask), update); });
  *kernel.ignored += bad;
}

AdamState::AdamState(const Gaussians& gaussians)
    : m(gaussians.ZerosLike()),
      v(m.ZerosLike()),
      updated(AdamGroupCount(gaussians.size()), 0),
      ignored(1, 0) {}

void AdamState::Upload(const AdamState& from, Stream& stream) {
  m.Upload(from.m, stream);
  v.Upload(from.v, stream);
  step = from.step;
  updated.Upload(from.updated, stream);
  ignored.Upload(from.ignored, stream);
}

void AdamState::Download(AdamState& to, Stream& stream) const {
  m.Download(to.m, stream);
  v.Download(to.v, stream);
  to.step = step;
  updated.Download(to.updated, stream);
  ignored.Download(to.ignored, stream);
}

void AdamStepAll(const AdamSettings& settings,
                 const Gaussians& gradients,
                 View<const float> position_rate_scale,
                 View<const float> update_mask,
                 Gaussians& values,
                 AdamState& state,
                 Stream& stream,
                 const uint32_t* overflowed) {
  const size_t groups = state.updated.size();
  state.behind.Refill(groups, stream);
  ForEach(groups,
          stream,
          FindBehind{update_mask,
                     state.step,
                     state.step + 1,
                     state.updated.view(),
                     state.behind.view(),
                     overflowed});
  ++state.step;
  Update(settings, &gradients, position_rate_scale, values, state, stream);
}

void AdamCatchUpAll(const AdamSettings& settings,
                    View<const float> position_rate_scale,
                    Gaussians& values,
                    AdamState& state,
                    Stream& stream) {
  const size_t groups = state.updated.size();
  state.behind.Refill(groups, stream);
  ForEach(
      groups,
      stream,
      FindBehind{{}, state.step, state.step, state.updated.view(), state.behind.view(), nullptr});
  Update(settings, nullptr, position_rate_scale, values, state, stream);
}

}  // namespace cosplat
