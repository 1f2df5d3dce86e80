// Short trainings of a static scene, on the CPU and on the device.
#pragma once

#include <memory>
#include <vector>

#include "splat/render/cuda/tape.h"
#include "splat/train/step/step_engine.h"
#include "splat/train/subject/scene_subject.h"
#include "splat/train/trainer.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/random_gaussians.h"

namespace cosplat::test {

// Small, so that an emulated device takes seconds.
struct TrainingRun {
  TrainSettings settings = ShortRun(300, 1);
  Gaussians first = RandomGaussians(80, 1, Basis::kDcsh, 5);
  std::vector<TrainFrame> frames = Frames(true);

  static std::vector<TrainFrame> Frames(bool with_alpha) {
    return TargetImages(TrueScene(1, 20), Ring(4, 2.2f, 24), with_alpha);
  }

  TrainingRun() {
    settings.schedule.densify_from = 10;
    settings.schedule.densify_every = 30;
    settings.schedule.opacity_reset_every = 60;
    settings.density.max_count = 160;
    settings.background = Background::kRandom;
  }
};

struct Training {
  std::vector<double> losses;  // of every step, the last but one the last that a device tells
  TrainingState state;
};

inline Training RunOn(const TrainingRun& run, const StepEngineMaker& engine, int steps) {
  SceneSubject subject(run.frames, 1);
  Trainer trainer(run.settings, subject, run.first, engine);
  Training training;
  for (int i = 0; i < steps; ++i) training.losses.push_back(trainer.Step().loss);
  training.state = trainer.state();
  return training;
}

inline StepEngineMaker OnDevice(cuda::SumOrder order,
                                const InstanceForecast& forecast = InstanceForecast()) {
  return StepEngineOn(Device::kCuda, order == cuda::SumOrder::kFixed, forecast);
}

}  // namespace cosplat::test
