// Images that `cosplat-study bench` trains on: of the procedural head, or a scene given by the
// user.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/study/bench/step_timer.h"
#include "splat/base/camera.h"
#include "splat/gaussians.h"
#include "splat/train/trainer.h"

namespace cosplat {

struct BenchScene {
  std::string name;
  std::vector<TrainFrame> train, test;
  std::vector<float> points;          // [P, 3] initial Gaussian positions, world units
  std::vector<uint8_t> point_colors;  // [P, 3]
  float extent = 1;
  Background background = Background::kBlack;
  size_t max_gaussians = 0;
};

// The procedural head at rest, seen from all sides; `views` images of `side` px, every fifth held
// out. The initial Gaussians are grey and lie on its vertices.
BenchScene MakeHeadScene(int side, int views);

// A folder in train-scene's format; every 8th view is held out if it has no test views.
BenchScene LoadBenchScene(const std::string& path, int resolution);

struct TrainedScene {
  Gaussians gaussians;
  double seconds = 0;  // in the training loop
  double psnr = 0;     // dB, mean over the held-out views at full size
  std::vector<MemoryPart> memory;
};

// Parameters in which training runs differ.
struct TrainingChoice {
  int divisor = 1;  // downscaling factor of the training images
  int iterations = 0;
  uint64_t seed = 0;
  StepShortcuts shortcuts = {};
};

// Held-out views are rendered with the exact exponential, whichever one training used.
TrainedScene TrainBenchScene(const BenchScene& scene, const TrainingChoice& choice);

// Milliseconds per further step of such a run: the mean of `steps`.
double StepMs(const BenchScene& scene,
              const TrainingChoice& choice,
              const Gaussians& trained,
              int steps);

// Work required by a view: pixel-splat pairs in the blend loop.
struct PairCounts {
  // Pixels of the blocks that a splat reaches, while any pixel of the block still accepts splats:
  // the lanes that the blend loop processes.
  uint64_t evaluated = 0;
  // Those with an alpha of at least 1/255, at pixels that are not yet opaque.
  uint64_t contributing = 0;
};

// One view over a black background, with all stored colour bands.
PairCounts CountPairs(const Gaussians& gaussians, const Camera& camera);

}  // namespace cosplat
