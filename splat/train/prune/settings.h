// How a run prunes: the name of a rule (splat/train/prune/pruner.h), and its settings.
#pragma once

#include <cstddef>
#include <string>

namespace cosplat {

struct PruneSettings {
  std::string rule = "none";
  // Ranking rules: number of Gaussians left by the last round; 0: the rule's own shares.
  size_t target = 0;
  // Rules that learn a mask: weight of its loss; 0: the rule's default.
  float mask_weight = 0;
  // Any rule, at each densification and round: maximum per group (splat/train/density/density.h,
  // Placement::Groups); the lowest scores above it are removed. 0: none.
  int group_cap = 0;

  bool prunes() const { return rule != "none"; }
};

}  // namespace cosplat
