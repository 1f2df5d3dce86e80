#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>

#include "apps/cosplat/options/choice.h"
#include "apps/cosplat/options/command_line.h"
#include "apps/cosplat/options/train_options.h"

namespace cosplat {

namespace {

const CLI::Validator kRate(
    [](std::string& text) {
      char* end = nullptr;
      const double value = std::strtod(text.c_str(), &end);
      const bool ok = end != text.c_str() && std::isfinite(value) && value >= 0;
      return ok ? std::string() : "'" + text + "' is not a number >= 0";
    },
    "FLOAT >= 0");

// -1: left open, as earlier versions had it.
const CLI::Validator kInterval(
    [](std::string& text) {
      char* end = nullptr;
      const long value = std::strtol(text.c_str(), &end, 10);
      const bool ok = end != text.c_str() && (value == -1 || (value > 0 && value <= 1000000000));
      return ok ? std::string() : "'" + text + "' is not a number of steps > 0";
    },
    "INT > 0");
const CLI::Range kStep(-1, 1000000000);

const Choices<Basis>& BasisChoices() {
  static const Choices<Basis> choices = [] {
    Choices<Basis> all;
    for (size_t i = 0; i < kBasisNames.size(); ++i) all.emplace_back(kBasisNames[i], Basis(i));
    return all;
  }();
  return choices;
}

const Choices<std::optional<Background>> kBackgrounds{{"auto", std::nullopt},
                                                      {"black", Background::kBlack},
                                                      {"white", Background::kWhite},
                                                      {"random", Background::kRandom}};

const Choices<bool> kBudgets{{"none", false}, {"auto", true}};

void DeclareRun(TrainOptions& o, CLI::App& command) {
  BeginGroup(command, "Run");
  AddDevice(command, o.device, "where to train; auto: on an NVIDIA GPU if there is one");
  command.add_option("--seed", o.seed, "seed of all random numbers");
  CLI::Option* again = command.add_flag(
      "--resume", o.resume, "go on with the interrupted run in the results' folder");
  again->configurable(false);
  command.add_flag("--overwrite", o.overwrite, "replace the run that the results' folder holds")
      ->configurable(false)
      ->excludes(again);
  command
      .add_flag("--strict", o.strict, "refuse data of which `cosplat check` says that it is wrong")
      ->configurable(false);
  command.add_flag("--quiet", o.quiet, "print nothing but errors");
  BeginGroup(command, "More: run");
  command.add_flag("--deterministic",
                   o.deterministic,
                   "bit-identical runs on a GPU as well, by summing in a fixed order; CPU runs "
                   "always are");
  command
      .add_option("--checkpoint-every",
                  o.checkpoint_every,
                  "minutes between checkpoints, from which --resume goes on; 0: only when the run "
                  "is interrupted (Ctrl-C, SIGTERM)")
      ->check(kRate);
  // An empty list must not appear in config.ini, as it could not be read back.
  command.add_option("--test_iterations", o.test_iterations, "evaluate at these steps")
      ->default_str("");
  command.add_option("--save_iterations", o.save_iterations, "save at these steps")
      ->default_str("");
  command.add_flag(
      "--fold",
      o.fold,
      "hold some training views out (every 8th; of a video the last fifth) instead of the test "
      "views: for choosing settings");
}

void DeclareModel(TrainOptions& o, CLI::App& command) {
  BeginGroup(command, "Model");
  command.add_option("--iterations", o.iterations, "training steps")
      ->check(CLI::Range(1, 10000000));
  command.add_option("--sh_degree", o.sh_degree, "highest band of the view-dependent colour")
      ->check(CLI::Range(0, kMaxTrainedDegree));
  command
      .add_option("--max-gaussians,--max_gaussians", o.max_gaussians, "hard limit on their number")
      ->check(CLI::Range(size_t(1), kMaxGaussians));
  AddChoice(command,
            "--budget",
            o.finds_budget,
            kBudgets,
            "auto: remove Gaussians that the training images can do without (docs/study.md)");
  BeginGroup(command, "More: model");
  command
      .add_option(
          "--tolerance", o.tolerance, "dB that the training images may lose by --budget auto")
      ->check(kRate);
  AddChoice(command,
            "--basis",
            o.basis,
            BasisChoices(),
            "basis of the view-dependent colour: dcsh; sh: 3DGS's; dcsh-released: DCSHARP's "
            "released code; dcsh-literal: its published formula, which cannot be saved");
  AddChoice(command,
            "--background",
            o.background,
            kBackgrounds,
            "in training; auto: avatars random, renderings with alpha white, photographs black");
  command.add_flag("-w,--white_background", o.white_background, "the same as --background white");
  command
      .add_option(
          "--drop-bands,--drop_bands",
          o.drop_bands,
          "drop bands of colour that change the images by at most this, in grey levels of 255 "
          "(root mean square); 0: none")
      ->check(kRate);
}

void DeclarePruning(TrainOptions& o, CLI::App& command) {
  BeginGroup(command, "More: pruning");
  Choices<std::string> rules;
  for (const std::string& name : PruneRuleNames()) rules.emplace_back(name, name);
  AddChoice(command,
            "--prune",
            o.prune,
            rules,
            "rule for pruning Gaussians in addition to density control (docs/study.md)")
      ->transform([](const std::string& name) { return FindPruneRule(name).name; });
  AddOptional<size_t>(command,
                      "--prune-to",
                      o.prune_to,
                      "leave this many Gaussians; for rules that rank, by default leave-one-out",
                      0)
      ->check(CLI::Range(size_t(0), kMaxGaussians));
  AddOptional<float>(command,
                     "--prune-lambda,--prune_lambda",
                     o.prune_lambda,
                     "weight of the mask's loss, for rules that learn a mask",
                     0.0f)
      ->check(kRate);
}

void DeclareLoss(TrainOptions& o, CLI::App& command) {
  BeginGroup(command, "More: loss");
  command.add_option("--lambda_dssim", o.lambda_dssim, "share of D-SSIM in the loss")
      ->check(kRate)
      ->check(CLI::Range(0.0, 1.0));
  command
      .add_option("--lambda_lpips",
                  o.lambda_lpips,
                  "weight of LPIPS in the loss, by the net of --lpips; 0: off")
      ->check(kRate);
  command
      .add_option("--lpips-crop",
                  o.lpips_crop,
                  "side of the random part of the image that it is computed on, in pixels")
      ->check(CLI::Range(1, 100000));
  command
      .add_option("--lpips",
                  o.lpips,
                  "LPIPS by the net in this folder: NET_backbone.onnx, NET_lin.npz and "
                  "NET_taps.txt (docs/lpips.md); also of the held-out images")
      ->default_str("");
}

void DeclareSchedule(TrainOptions& o, CLI::App& command) {
  BeginGroup(command, "More: schedule (what is not given follows from preset and --iterations)");
  AddOptional<float>(command,
                     "--densify_grad_threshold",
                     o.densify_grad_threshold,
                     "mean screen gradient from which Gaussians are added (2e-4)",
                     0.0f)
      ->check(kRate);
  AddOptional<int>(
      command, "--densify_from_iter", o.densify_from, "first step that adds Gaussians", -1)
      ->check(kStep);
  AddOptional<int>(
      command, "--densify_until_iter", o.densify_until, "last step that adds Gaussians", -1)
      ->check(kStep);
  AddOptional<int>(command,
                   "--densification_interval",
                   o.densify_every,
                   "steps between adding and removing Gaussians",
                   -1)
      ->check(kInterval);
  AddOptional<int>(command,
                   "--opacity_reset_interval",
                   o.opacity_reset_every,
                   "steps between resets of the opacities",
                   -1)
      ->check(kInterval);
  AddOptional<int>(command,
                   "--num-downscales,--num_downscales",
                   o.num_downscales,
                   "how often the sides of the first images are halved",
                   -1)
      ->check(CLI::Range(-1, 6));
  AddOptional<int>(command,
                   "--resolution-schedule,--resolution_schedule",
                   o.resolution_schedule,
                   "steps after which the sides of the images double (a tenth of the run)",
                   -1)
      ->check(kInterval);
}

void DeclareRates(TrainOptions& o, CLI::App& command) {
  BeginGroup(command, "More: learning rates");
  command.add_option("--position_lr_init", o.position_lr_init, "initial one of positions")
      ->check(kRate);
  AddOptional<float>(command,
                     "--position_lr_final",
                     o.position_lr_final,
                     "final one of positions (a hundredth of the first in 30,000 steps, more in "
                     "shorter runs); 0: the first one stays")
      ->check(kRate);
  AddOptional<float>(command, "--feature_lr", o.feature_lr, "of colours (the preset's)")
      ->check(kRate);
  AddOptional<float>(
      command, "--rest-lr,--rest_lr", o.rest_lr, "of colour bands 1 and up (feature_lr / 20)")
      ->check(kRate);
  AddOptional<float>(command, "--opacity_lr", o.opacity_lr, "of opacities (the preset's)")
      ->check(kRate);
  AddOptional<float>(command, "--scaling_lr", o.scaling_lr, "of log scales (the preset's)")
      ->check(kRate);
  AddOptional<float>(command, "--rotation_lr", o.rotation_lr, "of rotations (the preset's)")
      ->check(kRate);
}

}  // namespace

CLI::Option* AddDevice(CLI::App& command,
                       std::optional<Device>& device,
                       const std::string& description) {
  static const Choices<std::optional<Device>> devices{
      {"auto", std::nullopt}, {"cpu", Device::kCpu}, {"cuda", Device::kCuda}};
  return AddChoice(command, "--device", device, devices, description);
}

void TrainOptions::DeclareFolders(CLI::App& command) {
  BeginGroup(command, "Data");
  command.add_option("-s,--source_path", source, "the data set's folder")->required();
  command.add_option("-m,--model_path", model, "where results go")->required();
}

void TrainOptions::DeclareTraining(CLI::App& command) {
  BeginGroup(command, "Data");
  command.add_option("-r,--resolution", resolution, "divide the images' size by this")
      ->check(CLI::Range(1, 64));
  command.add_flag("--eval", eval, "hold test views out and evaluate on them at the end");
  DeclareModel(*this, command);
  DeclareRun(*this, command);
  DeclarePruning(*this, command);
  DeclareLoss(*this, command);
  DeclareSchedule(*this, command);
  DeclareRates(*this, command);
}

void TrainOptions::DeclareQuality(CLI::App& command, const std::string& description) {
  static const Choices<std::optional<Quality>> qualities{
      {"draft", Quality::kDraft}, {"standard", Quality::kStandard}, {"best", Quality::kBest}};
  BeginGroup(command, "Quality");
  AddChoice(command, "--quality", quality, qualities, description)->run_callback_for_default(false);
}

bool SetUnlessGiven(CLI::App& command, const std::string& name, const std::string& value) {
  CLI::Option* option = command.get_option(name);
  if (option->count() > 0) return false;
  const bool before = option->get_run_callback_for_default();
  option->run_callback_for_default()->default_val(value)->run_callback_for_default(before);
  return true;
}

void TrainOptions::Settle(CLI::App& command,
                          const OptionValues& of_preset,
                          const OptionValues& (*of_quality)(Quality)) {
  for (const auto& [name, value] : of_preset) SetUnlessGiven(command, name, value);
  settled.clear();
  if (!quality) return;
  for (const auto& [name, value] : of_quality(*quality))
    settled += " " + name + " " + (SetUnlessGiven(command, name, value) ? value : "as it is given");
}

}  // namespace cosplat
