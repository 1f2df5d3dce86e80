#include "tests/gpu/training_times.h"

#include <algorithm>
#include <chrono>

#include "splat/train/step/step_engine.h"
#include "splat/train/subject/scene_subject.h"
#include "splat/train/trainer.h"

namespace cosplat::test {
namespace {

// A device may have some of the last step left to do, which is one of many.
double MillisecondsOf(Trainer& trainer, int steps) {
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < steps; ++i) trainer.Step();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

TrainingTimes TimeTraining(const SyntheticView& view, const StepEngineMaker& engine, int steps) {
  SceneSubject subject({view.frame}, 1);
  TrainSettings settings;
  settings.iterations = 2 * steps + 3;
  settings.first_degree = view.start.degree;
  settings.schedule.densify_from = 2 * steps;
  settings.schedule.densify_every = 2 * steps + 1;
  settings.density.max_count = size_t(-1);
  Trainer trainer(settings, subject, view.start, engine);
  TrainingTimes times;
  MillisecondsOf(trainer, steps);
  times.step_ms = MillisecondsOf(trainer, steps) / steps;
  // It waits for itself; of the steps before and after it, one is left to do at either end.
  times.density_ms = MillisecondsOf(trainer, 2) - 2 * times.step_ms;
  times.gaussians = trainer.count();
  return times;
}

void WriteTimes(std::FILE* file, const char* name, const TrainingTimes& t, const char* end) {
  std::fprintf(file,
               "       \"%s\": {\"step_ms\": %.4f, \"density_ms\": %.4f, \"gaussians\": %zu}%s\n",
               name,
               t.step_ms,
               t.density_ms,
               t.gaussians,
               end);
}

}  // namespace

TrainingComparison CompareTraining(const SyntheticView& view, int steps) {
  constexpr int kCpuSteps = 2;
  return {TimeTraining(view, StepEngineOn(Device::kCuda, false), steps),
          TimeTraining(view, StepEngineOn(Device::kCuda, true), steps),
          TimeTraining(view, MakeHostStepEngine, std::min(steps, kCpuSteps))};
}

void WriteJson(std::FILE* file, const TrainingComparison& training) {
  std::fprintf(file, "     \"training\": {\n");
  WriteTimes(file, "any_order", training.any_order, ",");
  WriteTimes(file, "fixed_order", training.fixed_order, ",");
  WriteTimes(file, "cpu", training.cpu, "},");
}

}  // namespace cosplat::test
