// Photographs that `cosplat bench` trains on: a made head's, or a scene of the user's.
#pragma once

#include <string>
#include <vector>

#include "apps/study/bench/step_timer.h"
#include "splat/train/trainer.h"

namespace cosplat {

struct BenchScene {
  std::string name;
  std::vector<TrainFrame> train, test;
  std::vector<float> points;          // [P, 3] where Gaussians begin, world units
  std::vector<uint8_t> point_colors;  // [P, 3]
  float extent = 1;
  std::string background = "black";  // as --background
  size_t max_gaussians = 0;
};

// The procedural head at rest, seen from all sides; `views` images of `side` px, every fifth held
// out. Gaussians begin grey on its vertices.
BenchScene MakeHeadScene(int side, int views);

// A folder as train-scene takes it, every 8th view held out where it has no test views.
BenchScene LoadBenchScene(const std::string& path, int resolution);

struct TrainedScene {
  Gaussians gaussians;
  double seconds = 0;  // in the training loop
  double psnr = 0;     // dB, mean over the held-out views at full size
  std::vector<MemoryPart> memory;
};

// What a training run may differ in.
struct TrainingChoice {
  int divisor = 1;  // of the training images' size
  int iterations = 0;
  uint64_t seed = 0;
  StepShortcuts shortcuts = {};
  bool half_moments = false;  // of the colours' higher bands (apps/study/bench/half_adam.h)
};

// Held-out views are drawn with the exact exponential whatever the training had.
TrainedScene TrainBenchScene(const BenchScene& scene, const TrainingChoice& choice);

// A further step of such a run, ms: the mean of `steps`. Moments are floats.
double StepMs(const BenchScene& scene,
              const TrainingChoice& choice,
              const Gaussians& trained,
              int steps);

}  // namespace cosplat
