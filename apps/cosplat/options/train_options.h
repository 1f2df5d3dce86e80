// Options of both trainers, with the names and meanings of 3DGS's where it has them.
//
// train_options.cpp knows no command line: the benchmark of a device trains by it, too (tests/gpu).
// train_options_cli.cpp declares them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "splat/render/device.h"
#include "splat/train/step_engine.h"
#include "splat/train/trainer.h"

namespace CLI {
class App;
}

namespace cosplat {

// Far more than any machine holds; more is a slip of the finger.
constexpr size_t kMaxGaussians = 1000000000;

struct TrainOptions {
  std::string source, model;
  int resolution = 1;
  bool eval = false;
  bool fold = false;
  int iterations = 30000;
  int sh_degree = 3;
  std::string basis = "dcsh";
  std::string preset = "default";
  std::string background = "auto";
  bool white_background = false;
  std::vector<int> test_iterations, save_iterations;
  uint64_t seed = 0;
  size_t max_gaussians = 2000000;
  std::string device = "cpu";
  bool deterministic = false;
  std::string prune = "none";
  size_t prune_to = 0;
  float prune_lambda = 0;
  float drop_bands = 0;  // grey levels of 255
  std::string budget = "none";
  float tolerance = 0.2f;  // dB
  float lambda_dssim = 0.2f;
  float densify_grad_threshold = 2e-4f;
  // Steps; -1: by the schedule.
  int densify_from = -1, densify_until = -1, densify_every = -1, opacity_reset_every = -1;
  int num_downscales = -1, resolution_schedule = -1;
  LearningRates rates;
  float position_lr_final = 0;  // 0: Schedule::LastPositionRate
  float scaling_lr = 0;         // 0: as the preset says
  bool quiet = false;

  // Declares them on a sub-command; defaults are the values at the time of the call.
  void Declare(CLI::App& command);
  // `extent`: world units that size limits scale with.
  TrainSettings ToSettings(float extent) const;
  // Settles --device; a rule of pruning that works on the processor alone settles "auto", too.
  Device ResolveDevice() const;
  // Settles --background auto and -w.
  void ResolveBackground(const std::string& automatic);
  // Behind held-out images: black where training has black, otherwise white.
  std::array<float, 3> EvaluationBackground() const;
  bool ReachesMilestone(const std::vector<int>& milestones, int iteration) const;
};

// All options of a sub-command with their values, as `--config` reads them.
std::string ConfigOf(const CLI::App& app, const CLI::App& command);

}  // namespace cosplat
