#include "apps/study/bench/step_timer.h"

#include <algorithm>
#include <limits>

#include "apps/study/bench/measure.h"

namespace cosplat {
namespace {

constexpr int kNever = std::numeric_limits<int>::max();

}  // namespace

TrainSettings SteadySettings(int degree) {
  TrainSettings s;
  s.degree = s.first_degree = degree;
  s.schedule.densify_from = s.schedule.densify_until = kNever;
  s.schedule.opacity_reset_every = kNever;
  return s;
}

StepTimes TimeSteps(std::vector<TrainFrame> frames,
                    const Gaussians& first,
                    int warm_up,
                    int steps,
                    const StepShortcuts& shortcuts) {
  SceneSubject subject(std::move(frames), 1);
  TrainSettings settings = SteadySettings(first.degree);
  settings.exp_degree = shortcuts.exp_degree;
  settings.adam_on = shortcuts.adam_on;
  Trainer trainer(settings, subject, first);
  for (int i = 0; i < warm_up; ++i) trainer.Step();
  const TrainingStatistics before = trainer.statistics();
  StepTimes times;
  times.fastest_ms = std::numeric_limits<double>::infinity();
  for (int i = 0; i < steps; ++i) {
    const auto start = std::chrono::steady_clock::now();
    trainer.Step();
    times.fastest_ms = std::min(times.fastest_ms, 1e3 * SecondsSince(start));
  }
  const TrainingStatistics after = trainer.statistics();
  times.mean_ms = 1e3 * (after.seconds - before.seconds) / steps;
  for (size_t i = 0; i < after.times.seconds.size(); ++i)
    times.mean_phases.seconds[i] = (after.times.seconds[i] - before.times.seconds[i]) / steps;
  return times;
}

StepTimes TimeSteps(const SyntheticView& view, int warm_up, int steps) {
  return TimeSteps({view.frame}, view.start, warm_up, steps);
}

}  // namespace cosplat
