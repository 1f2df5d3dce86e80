#include "apps/cosplat/options/presets.h"

#include <map>

namespace cosplat {
namespace {

// Differences from 3DGS in the training of scenes; docs/reference.md lists the gain of each.
PresetRules SceneDefault() {
  PresetRules rules;
  rules.rates.scale = 1e-2f;
  rules.rates.opacity = 0.025f;
  rules.rates.rotation = 2e-3f;
  rules.color_rate_by_length = true;
  rules.shares_opacity = true;
  // What is large beside the distance between the cameras is the background, not a fault.
  rules.limits_scale = false;
  rules.opacity_reset_share = 0.25f;
  rules.num_downscales = 2;
  rules.last_rate_share = 0.2f;
  // With its filters fewer Gaussians would be added (docs/scenes.md).
  rules.antialiased_grad_threshold = 1.6e-4f;
  // Exact cameras and no noise: more detail is there, and more Gaussians do not overfit.
  rules.renderings_grad_threshold = 1.5e-4f;
  // In long runs it loses (docs/reference.md).
  rules.long_axis_max_steps = 7500;
  rules.long_axis_renderings_grad_threshold = 1.75e-4f;
  // Nor is there anything in them that squares would give too much weight.
  rules.renderings_late_mse = 30;
  rules.color_curvature = 0.0075f;
  return rules;
}

// Blocks that are trained beside each other, each towards what the others lacked before, disagree
// more the further they go: the made scene of the test `blocks` loses 0.5 dB by the rates of one
// piece.
PresetRules BlockDefault() {
  PresetRules rules = SceneDefault();
  rules.rates = LearningRates();
  rules.rates.scale = SceneDefault().rates.scale;
  rules.color_rate_by_length = false;
  rules.long_axis_max_steps = 0;
  rules.renderings_late_mse = 0;
  rules.color_curvature = 0;
  return rules;
}

PresetRules Of3dgs() {
  PresetRules rules;
  rules.in_proportion = false;
  return rules;
}

// Chosen on held-out training frames of three heads (docs/tried.md). Shared opacity degrades
// mouths.
PresetRules AvatarDefault() {
  PresetRules rules;
  rules.num_downscales = 2;
  rules.last_rate_share = 0.2f;
  return rules;
}

// Half the steps, and more Gaussians sooner.
PresetRules AvatarQuick() {
  PresetRules rules = AvatarDefault();
  rules.options = {{"--iterations", "3000"}, {"--densify_grad_threshold", "0.00015"}};
  return rules;
}

// SplattingAvatar's values, which agree in the paper and its released code. The learning rates are
// for 30,000 steps and are not adjusted in shorter runs.
PresetRules SplattingAvatar(AvatarSystem system) {
  PresetRules rules;
  rules.options = {
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
  rules.mse = 10;
  rules.all_bands_at_start = true;
  rules.densify_from = 600;
  rules.densify_until = 29000;
  rules.system = system;
  return rules;
}

}  // namespace

const PresetRules& SceneRules(Preset preset) {
  static const PresetRules ours = SceneDefault(), of_3dgs = Of3dgs();
  return preset == Preset::k3dgs ? of_3dgs : ours;
}

const PresetRules& BlockRules() {
  static const PresetRules rules = BlockDefault();
  return rules;
}

const PresetRules& AvatarRules(Preset preset) {
  static const std::map<Preset, PresetRules> rules{
      {Preset::kCosplat, AvatarDefault()},
      {Preset::kQuick, AvatarQuick()},
      {Preset::k3dgs, Of3dgs()},
      {Preset::kSplattingAvatar, SplattingAvatar(AvatarSystem::kPublished)},
      {Preset::kSplattingAvatarReleased, SplattingAvatar(AvatarSystem::kReleased)},
  };
  return rules.at(preset);
}

const OptionValues& SceneValues(Quality quality) {
  static const std::map<Quality, OptionValues> values{
      {Quality::kDraft, {{"--iterations", "2000"}}},
      {Quality::kStandard, {{"--iterations", "7000"}}},
      {Quality::kBest, {{"--iterations", "30000"}}},
  };
  return values.at(quality);
}

const OptionValues& AvatarValues(Quality quality) {
  static const std::map<Quality, OptionValues> values{
      {Quality::kDraft, {{"--iterations", "2000"}, {"--densify_grad_threshold", "0.00015"}}},
      {Quality::kStandard, {{"--iterations", "6000"}}},
      {Quality::kBest, {{"--iterations", "15000"}}},
  };
  return values.at(quality);
}

}  // namespace cosplat
