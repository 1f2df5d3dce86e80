#include "apps/cosplat/options/avatar_options.h"

#include <cmath>
#include <utility>
#include <vector>

#include "avatar/model/corrections.h"

namespace cosplat {
namespace {

using PresetValues = std::vector<std::pair<std::string, std::string>>;  // option, value

// SplattingAvatar's values, which agree in the paper and its released code, by the names of our
// options. The learning rates are for 30,000 steps and are not adjusted in shorter runs.
const PresetValues& SplattingAvatarValues() {
  static const PresetValues values{
      {"--gaussians", "10000"},
      {"--sh_degree", "0"},
      {"--basis", "sh"},
      {"--color-frame", "world"},
      {"--bust", "no"},
      {"--mouth", "no"},
      {"--light_lr", "0"},
      {"--triangle-cap", "0"},
      {"--prune", "none"},
      {"--lambda_dssim", "0"},
      {"--densify_grad_threshold", "0.0002"},
      {"--position_lr_init", "0.00016"},
      {"--position_lr_final", "1.6e-06"},
      {"--feature_lr", "0.0025"},
      {"--opacity_lr", "0.05"},
      {"--scaling_lr", "0.005"},
      {"--rotation_lr", "0.001"},
  };
  return values;
}

// Where there is a network; SplattingAvatar's is AlexNet.
constexpr const char* kSplattingAvatarLpips = "0.01";

// Half the steps, and more Gaussians sooner: about the quality
// of the defaults on videos of some 200 frames, in less than half the time (docs/results.md).
const PresetValues& QuickValues() {
  static const PresetValues values{
      {"--iterations", "3000"},
      {"--densify_grad_threshold", "0.00015"},
  };
  return values;
}

// For 30,000 steps.
constexpr int kSplattingAvatarSteps = 30000;
constexpr int kSplattingAvatarDensifyFrom = 600;
constexpr int kSplattingAvatarDensifyUntil = 29000;
constexpr float kSplattingAvatarMse = 10;

AvatarSystem SystemOf(const std::string& preset) {
  if (preset == "splatting-avatar") return AvatarSystem::kPublished;
  return preset == "splatting-avatar-released" ? AvatarSystem::kReleased : AvatarSystem::kCosplat;
}

}  // namespace

AvatarOptions::AvatarOptions() {
  iterations = 6000;
  sh_degree = 2;  // as good as 3 on held-out training frames (docs/tried.md)
  // SplattingAvatar's 1.6e-4 is for 30,000 steps; the distance that a Gaussian can move is the
  // learning rate times the number of steps.
  rates.position_lr_init = 6.4e-4f;
  preset = "cosplat";
}

void AvatarOptions::Declare(CLI::App& command) {
  DeclareFolders(command);
  command.get_option("--source_path")
      ->description(
          "tracked video: a folder of IMavatar's, VHAP's (GaussianAvatars'), INSTA's, "
          "metrical-tracker's or SMIRK's layout");
  DeclareTraining(command);
}

void AvatarOptions::DeclareTraining(CLI::App& command) {
  TrainOptions::DeclareTraining(command);
  command.add_option("--flame", flame, "FLAME model file (.pkl or .npz)")->required();
  command.add_option("--landmarks",
                     landmarks,
                     "landmarks file of the video with blendshape scores: fits the map by which "
                     "face trackers drive the avatar");
  command.add_flag(
      "--fold-by-turn",
      fold_by_turn,
      "hold the fifth of the training frames out in which the head is turned furthest, "
      "instead of the test frames: for choosing what has to hold in poses not seen");
  command
      .add_option(
          "--test-frames", test_frames, "hold the last N frames out; -1: the video's own split")
      ->check(CLI::Range(-1, 1000000000));
  command
      .add_option("--focal-scale",
                  focal_scale,
                  "the camera's focal length as a multiple of the track's, which may be a guess; "
                  "compare values by what they reach with --fold")
      ->check(CLI::Range(0.01, 100.0));
  command.add_option("--gaussians", avatar.initial_gaussians, "Gaussians to start with")
      ->check(CLI::Range(size_t(1), kMaxGaussians));
  command
      .add_option("--triangle-cap,--triangle_cap",
                  triangle_cap,
                  "most Gaussians on one triangle; 0: no limit")
      ->check(CLI::Range(0, 1000000000));
  command
      .add_option("--color-frame,--color_frame",
                  color_frame,
                  "frame of the view direction for colours: surface (moves with the skin) or world")
      ->check(CLI::IsMember({"surface", "world"}));
  command
      .add_option(
          "--bust", bust, "a sheet for shoulders, which FLAME lacks: yes, no, or auto by the masks")
      ->check(CLI::IsMember({"auto", "yes", "no"}));
  command
      .add_option(
          "--mouth", mouth, "teeth and the inside of the mouth, which FLAME lacks: yes or no")
      ->check(CLI::IsMember({"yes", "no"}));
  command
      .add_option("--corrections",
                  avatar.corrections,
                  "most bases per Gaussian that follow the expression; 0: none")
      ->check(CLI::Range(0, kMaxCorrections));
  command
      .add_option("--light_lr",
                  avatar.light_rate,
                  "learning rate of the light that stands still while the head turns; 0: no light")
      ->check(CLI::NonNegativeNumber);
  command.add_flag("--still-bust",
                   avatar.still_bust,
                   "hold the bust still, instead of finding where it is in each frame");
  command.add_flag("--refine-track",
                   avatar.refine_track,
                   "also optimise pose, translation and expression of the training frames");
  command.add_flag(
      "--embed-flame", embed_flame, "put the FLAME mesh into avatar.glb; mind the model's licence");
  command.add_flag(
      "--truncate-degree",
      truncate_degree,
      "with --sh_degree 4: leave band 4 out of what other programs read of avatar.glb");
  command
      .add_option(
          "--preset",
          preset,
          "quick: half the steps, and more Gaussians sooner; splatting-avatar: as published, with "
          "its LPIPS loss if --lpips has a network; "
          "splatting-avatar-released: as its code was released, faults included; 3dgs: "
          "absolute schedule steps; explicitly given options take precedence")
      ->check(CLI::IsMember(
          {"cosplat", "quick", "splatting-avatar", "splatting-avatar-released", "3dgs"}));
}

void AvatarOptions::ApplyPreset(CLI::App& command) {
  fold = fold || fold_by_turn;
  avatar.system = SystemOf(preset);
  const auto set = [&](const std::string& name, const std::string& value) {
    CLI::Option* option = command.get_option(name);
    if (option->count() == 0) option->default_val(value);  // also sets the variable
  };
  if (preset == "quick")
    for (const auto& [name, value] : QuickValues()) set(name, value);
  if (IsSplattingAvatar())
    for (const auto& [name, value] : SplattingAvatarValues()) set(name, value);
  if (IsSplattingAvatar() && !lpips.empty()) set("--lambda_lpips", kSplattingAvatarLpips);
  avatar.iterations = iterations;
  avatar.color_frame = color_frame == "world" ? ColorFrame::kWorld : ColorFrame::kSurface;
  using BustChoice = AvatarSettings::BustChoice;
  avatar.bust =
      bust == "yes" ? BustChoice::kYes : (bust == "no" ? BustChoice::kNo : BustChoice::kAuto);
}

TrainSettings AvatarOptions::ToSettings(float unit) const {
  TrainSettings settings = TrainOptions::ToSettings(1);
  settings.scale_regularizer.weight = 1;  // as in SplattingAvatar, for every preset
  settings.prune.group_cap = triangle_cap;
  // Pruning by triangle keeps at least one Gaussian on every triangle that has any.
  if (settings.prune.rule == PruneRule::kDcsharpTriangle) settings.prune.group_floor = 1;
  if (avatar.system == AvatarSystem::kCosplat && preset != "3dgs") {
    // Chosen on held-out training frames of three heads (docs/tried.md).
    if (num_downscales < 0) settings.schedule.num_downscales = 2;
    settings.schedule.last_rate_share = 0.2f;
  }
  if (IsSplattingAvatar()) {
    settings.loss.mse = kSplattingAvatarMse;
    settings.first_degree = sh_degree;  // all bands from the first step
    const auto scaled = [&](int steps) {
      return int(std::lround(double(steps) * iterations / kSplattingAvatarSteps));
    };
    if (densify_from < 0) settings.schedule.densify_from = scaled(kSplattingAvatarDensifyFrom);
    if (densify_until < 0) settings.schedule.densify_until = scaled(kSplattingAvatarDensifyUntil);
  }
  ScaleToUnit(unit, settings);
  return settings;
}

}  // namespace cosplat
