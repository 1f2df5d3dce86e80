// The rules of pruning by name, and what can be set (splat/prune/pruner.h).
#pragma once

#include <string>
#include <vector>

namespace cosplat {

enum class PruneRule {
  kNone,
  kLeaveOneOut,      // ours: by how much the images change
  kDcsharp,          // paper: mean |dL/ds|, lowest go
  kDcsharpReleased,  // its released code, faults included
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
  // Rules that rank: how many Gaussians the last round leaves; 0: the rule's own shares.
  size_t target = 0;
  // Rules that learn a mask: weight of its loss; 0: the rule's own.
  float mask_weight = 0;
  // Any rule, at each densification and round, per group (splat/train/density.h,
  // Placement::Groups).
  int group_cap = 0;    // more than this: the lowest scores go; 0: no cap
  int group_floor = 0;  // never fewer
};

std::string ToString(PruneRule rule);
// Error on a name that is not known.
PruneRule PruneRuleFromString(const std::string& text);
std::vector<std::string> PruneRuleNames();
bool LearnsMask(PruneRule rule);
// Whether the rule works in steps as no device does.
bool WorksOnProcessorOnly(PruneRule rule);

}  // namespace cosplat
