// Options shared by both trainers, with 3DGS's names and meanings where it has the same option.
//
// train_options.cpp does not depend on the command line, so that the GPU benchmark (tests/gpu) can
// train with it as well. train_options_cli.cpp declares the options.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "splat/render/device.h"
#include "splat/train/step/step_engine.h"
#include "splat/train/trainer.h"

namespace CLI {
class App;
}

namespace cosplat {

// Far more than fits into memory; a larger value is a typing error.
constexpr size_t kMaxGaussians = 1000000000;

struct TrainOptions {
  std::string source, model;
  int resolution = 1;
  bool eval = false;
  bool fold = false;
  bool antialiasing = false;
  bool exposure = false;  // of scenes
  int iterations = 30000;
  int batch = 1;  // of scenes
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
  float lambda_lpips = 0;
  int lpips_crop = 128;              // px
  std::string lpips;                 // a network's folder; empty: none
  float densify_grad_threshold = 0;  // 0: the preset's
  // In steps; -1: as in the schedule.
  int densify_from = -1, densify_until = -1, densify_every = -1, opacity_reset_every = -1;
  int num_downscales = -1, resolution_schedule = -1;
  LearningRates rates;
  float position_lr_final = 0;  // 0: Schedule::LastPositionRate
  float scaling_lr = 0;         // 0: the preset's
  float checkpoint_every = 5;   // minutes; 0: only when stopped by a signal
  bool resume = false, overwrite = false;
  bool strict = false;  // data that does not tell one story is refused
  bool quiet = false;

  // Declare the options on a sub-command; the current values become the defaults. First where the
  // data is and where results go, which not all commands are told in this way, then the others.
  void DeclareFolders(CLI::App& command);
  void DeclareTraining(CLI::App& command);
  // `extent`: scene size in world units; size limits are proportional to it. Leaves the network of
  // the crop loss to the caller. Throws Error if options contradict each other.
  TrainSettings ToSettings(float extent) const;
  // Resolves --device. "auto" is the CPU for what is only implemented there: some pruning rules.
  Device ResolveDevice() const;
  // Resolves --background auto and -w.
  void ResolveBackground(const std::string& automatic);
  // Background of held-out images: black if training uses black, otherwise white.
  std::array<float, 3> EvaluationBackground() const;
  // Whether a step to `iteration` that began after `before` reaches one of them, or the end.
  bool ReachesMilestone(const std::vector<int>& milestones, int before, int iteration) const;
};

// All options of a sub-command with their values, in the format that `--config` reads.
std::string ConfigOf(const CLI::App& app, const CLI::App& command);

}  // namespace cosplat
