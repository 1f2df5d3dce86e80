// What --preset and --quality stand for.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "avatar/train/avatar_subject.h"

namespace cosplat {

enum class Preset {
  kCosplat,                  // this project's settings
  kQuick,                    // of avatars: kCosplat with fewer steps
  k3dgs,                     // 3DGS's absolute schedule steps and, of scenes, its settings
  kSplattingAvatar,          // as published
  kSplattingAvatarReleased,  // its released code, including the faults in which it differs from the
                             // publication (avatar/train/avatar_subject.h, AvatarSystem)
};

using OptionValues = std::vector<std::pair<std::string, std::string>>;  // option, value

// A preset of a trainer: options that it sets, and what no option is for. Defaults are 3DGS's.
struct PresetRules {
  OptionValues options;
  bool in_proportion = true;  // schedules are fractions of the run, not 3DGS's numbers of steps
  LearningRates rates;
  bool color_rate_by_length = false;  // rates.color is that of 30,000 steps
  bool shares_opacity = false;        // between a clone and its original
  // Runs of so many steps or fewer cut Gaussians across their longest axis, from these gradients on
  // in renderings (DensitySettings::cuts_long_axis). Not with --antialiasing.
  int long_axis_max_steps = 0;
  float long_axis_renderings_grad_threshold = 0;
  bool limits_scale = true;  // Gaussians that are large beside the scene are removed
  float opacity_reset_share = 1;
  int num_downscales = 0;
  float last_rate_share = 1;
  float mse = 0;                                   // weight in the loss
  float renderings_late_mse = 0;                   // LateMse of renderings, of short runs
  float color_curvature = 0;                       // TrainSettings::color_curvature
  bool all_bands_at_start = false;                 // of colour
  std::optional<int> densify_from, densify_until;  // of 30,000 steps; none: 3DGS's
  // Screen gradients from which Gaussians are added. None: 3DGS's.
  std::optional<float> antialiased_grad_threshold, renderings_grad_threshold;
  AvatarSystem system = AvatarSystem::kCosplat;
};
const PresetRules& SceneRules(Preset preset);  // kCosplat or k3dgs
const PresetRules& BlockRules();               // of a scene that is trained in blocks
const PresetRules& AvatarRules(Preset preset);

enum class Quality { kDraft, kStandard, kBest };

// Options that a quality sets. They yield to options that are given, and count more than a
// preset's.
const OptionValues& SceneValues(Quality quality);
const OptionValues& AvatarValues(Quality quality);

}  // namespace cosplat
