// The pruning rules by name, and their settings (splat/train/prune/pruner.h).
#pragma once

#include <string>
#include <vector>

namespace cosplat {

enum class PruneRule {
  kNone,
  kLeaveOneOut,      // ours: change of the images
  kDcsharp,          // paper: mean |dL/ds|, removes the lowest
  kDcsharpReleased,  // its released code, errors included
  kDcsharpTriangle,  // kDcsharp with a floor per triangle (avatars)
  kLightGaussian,
  kCompact,
  kLp,
  kSpeedy,
  kOpacity,
  kRandom,
};

struct PruneSettings {
  PruneRule rule = PruneRule::kNone;
  // Ranking rules: number of Gaussians left by the last round; 0: the rule's own shares.
  size_t target = 0;
  // Rules that learn a mask: weight of its loss; 0: the rule's default.
  float mask_weight = 0;
  // Any rule, at each densification and round, per group (splat/train/density/density.h,
  // Placement::Groups).
  int group_cap = 0;    // maximum: the lowest scores above it are removed; 0: none
  int group_floor = 0;  // minimum
};

std::string ToString(PruneRule rule);
// Throws Error for an unknown name.
PruneRule PruneRuleFromString(const std::string& text);
std::vector<std::string> PruneRuleNames();
bool LearnsMask(PruneRule rule);
// Whether the rule works in every step, which is not supported on a device.
bool WorksOnProcessorOnly(PruneRule rule);

}  // namespace cosplat
