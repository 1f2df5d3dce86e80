// Options shared by both trainers, with 3DGS's names and meanings where it has the same option.
//
// train_options.cpp does not depend on the command line, so that the GPU benchmark (tests/gpu) can
// train with it as well. train_options_cli.cpp declares the options.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "apps/cosplat/options/presets.h"
#include "splat/render/device.h"
#include "splat/train/step/step_engine.h"
#include "splat/train/trainer.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace cosplat {

// Far more than fits into memory; a larger value is a typing error.
constexpr size_t kMaxGaussians = 1000000000;

struct TrainOptions {
  std::string source, model;
  int resolution = 1;
  bool eval = false;
  bool fold = false;
  bool antialiasing = false;
  bool exposure = false;    // of scenes
  bool renderings = false;  // the scene's images are (SceneData)
  std::optional<Quality> quality;
  Preset preset = Preset::kCosplat;
  int iterations = 30000;
  int batch = 1;  // of scenes
  int sh_degree = 3;
  Basis basis = Basis::kDcsh;
  std::optional<Background> background;  // none: what suits the data
  bool white_background = false;
  std::vector<int> test_iterations, save_iterations;
  uint64_t seed = 0;
  size_t max_gaussians = 2000000;
  std::optional<Device> device = Device::kCpu;  // none: a GPU if there is one
  bool deterministic = false;
  std::string prune = "none";  // a rule
  std::optional<size_t> prune_to;
  std::optional<float> prune_lambda;
  float drop_bands = 0;  // grey levels of 255
  bool finds_budget = false;
  double tolerance = PruneSettings().tolerance;  // dB
  float lambda_dssim = 0.2f;
  float lambda_lpips = 0;
  int lpips_crop = 128;  // px
  std::string lpips;     // a network's folder; empty: none
  // Where there is none, the preset's or the schedule's.
  std::optional<float> densify_grad_threshold, position_lr_final;
  std::optional<float> feature_lr, rest_lr, opacity_lr, scaling_lr, rotation_lr;
  std::optional<int> densify_from, densify_until, densify_every, opacity_reset_every;  // steps
  std::optional<int> num_downscales, resolution_schedule;
  float position_lr_init = LearningRates().position_lr_init;
  float checkpoint_every = 5;  // minutes; 0: only when stopped by a signal
  bool resume = false, overwrite = false;
  bool strict = false;  // data that does not tell one story is refused
  bool quiet = false;
  std::string settled;  // what --quality has set, and what not, since it is given

  // Declare the options on a sub-command; the current values become the defaults. First where the
  // data is and where results go, which not all commands are told in this way, then the others.
  void DeclareFolders(CLI::App& command);
  void DeclareTraining(CLI::App& command);
  // description: what each quality takes and reaches.
  void DeclareQuality(CLI::App& command, const std::string& description);
  // The settings of a scene in one piece. `extent`: its size in world units; size limits are
  // proportional to it. The caller adds the network of the crop loss. Throws Error if options
  // contradict each other.
  TrainSettings ToSettings(float extent) const { return SettingsBy(SceneRules(preset), extent); }
  // Resolves --device. "auto" is the CPU for what is only implemented there: some pruning rules.
  Device ResolveDevice() const;
  // Resolves --background auto and -w.
  void ResolveBackground(Background automatic);
  // Background of held-out images: black if training uses black, otherwise white.
  std::array<float, 3> EvaluationBackground() const;
  // Whether a step to `iteration` that began after `before` reaches one of them, or the end.
  bool ReachesMilestone(const std::vector<int>& milestones, int before, int iteration) const;

 protected:
  TrainSettings SettingsBy(const PresetRules& rules, float extent) const;
  Schedule ScheduleBy(const PresetRules& rules) const;
  // Sets what is not given on the command line or in a configuration; values: of the preset, and of
  // each quality.
  void Settle(CLI::App& command,
              const OptionValues& of_preset,
              const OptionValues& (*of_quality)(Quality));
};

// Declares --device, of any command. none: "auto".
CLI::Option* AddDevice(CLI::App& command,
                       std::optional<Device>& device,
                       const std::string& description);

// Gives an option another value where the user gave none, as its default in configuration files,
// too. Returns whether it did.
bool SetUnlessGiven(CLI::App& command, const std::string& name, const std::string& value);

}  // namespace cosplat
