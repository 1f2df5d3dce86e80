// Pruning: training removes Gaussians beyond those that density control removes (transparent,
// oversized). A rule is an entry of a table, to which programs may add theirs; rules rank the
// Gaussians, and the lowest are removed.
//
//   step (with its Mask) -> AfterBackward -> density control -> PrunesAt? -> Rank -> removal
//
// docs/study.md lists the rules and their source papers.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "splat/base/rng.h"
#include "splat/base/state_file.h"
#include "splat/gaussians.h"
#include "splat/train/optimize/schedule.h"
#include "splat/train/prune/importance.h"
#include "splat/train/prune/learned_mask.h"
#include "splat/train/state/density_statistics.h"

namespace cosplat {

struct PruneSettings {
  std::string rule = "none";
  // Ranking rules: number of Gaussians left by the last round; 0: the rule's own shares.
  size_t target = 0;
  // Leave-one-out without a target: dB that the training images may lose in all rounds together,
  // as if each Gaussian was removed alone and training did not go on. It does, so they lose less.
  double tolerance = 0.2;
  // Rules that learn a mask: weight of its loss; 0: the rule's default.
  float mask_weight = 0;
  // Any rule, at each densification and round: maximum per group (splat/train/density/density.h,
  // Placement::Groups); the lowest scores above it are removed. 0: none.
  int group_cap = 0;

  bool prunes() const { return rule != "none"; }
};

// The state of the run that a pruner ranks by.
struct PruneContext {
  int iteration = 0;                    // of the step just completed, counted from 1
  FrameImages& images;                  // of training frames
  View<const uint32_t> frames;          // frames to train on
  const Gaussians& gaussians;           // on a device, bands >= 1 may be out of date
  const DensityStatistics& statistics;  // since the last densification
  int degree = 0;                       // bands in use
  std::array<float, 3> background{0, 0, 0};
  Rng& rng;
};

struct PruneRound {
  std::vector<float> score;     // [N] the lowest are removed first
  std::vector<uint8_t> exempt;  // [N] 1: new or unseen, not removed by score; or empty
  size_t remove = 0;            // number of Gaussians to remove
  // At most so many that the sum of their scores is within this.
  double score_limit = std::numeric_limits<double>::infinity();
};

class Pruner {
 public:
  virtual ~Pruner() = default;

  // Whether there is a pruning round after step `iteration`.
  virtual bool PrunesAt(int iteration) const = 0;
  // Ranks the Gaussians that remain after density control.
  virtual PruneRound Rank(const PruneContext& context) = 0;

  // Called after a step's gradients and before Adam, on the host (PruneRule::on_host). radii: [N]
  // 0 where not rendered.
  virtual void AfterBackward(const Gaussians& /*gaussians*/,
                             const Gaussians& /*gradients*/,
                             View<const float> /*radii*/) {}
  // The mask to learn in every step; empty if the rule learns none, or none at present.
  virtual MaskInSteps Mask() { return {}; }
  virtual void BeforeDensification() {}
  // Bytes allocated by the rule.
  virtual size_t allocated_bytes() const { return 0; }
  // Writes what the rule keeps between steps to a checkpoint, or reads it, for `count` Gaussians.
  virtual void Serialize(StateArchive& /*archive*/, size_t /*count*/) {}
  // Reorders the rule's per-Gaussian data, on the host.
  virtual void Gather(const Reordering& order) { (void)order; }
};

// By the mean of |dL/ds| (s: the three standard deviations) over the steps since the last
// densification in which the Gaussian was visible: those whose shape the loss no longer changes
// are the lowest. Removes none.
PruneRound RankByPlasticity(const PruneContext& context);

// What a rule is made for.
struct PrunedRun {
  Schedule schedule;  // densify_until is not beyond the end
  int iterations;
  size_t gaussians;
};

struct PruneRule {
  std::string name;
  std::unique_ptr<Pruner> (*make)(const PruneSettings& settings, const PrunedRun& run) = nullptr;
  bool ranks = false;        // down to a target count
  bool learns_mask = false;  // in every step
  bool on_host = false;      // works in every step (AfterBackward), not supported on a device
  int group_floor = 0;       // Gaussians that a group keeps: for subjects that have groups
};

// Adds a rule, or replaces that of its name, for the whole program: before any is asked for.
void RegisterPruneRule(const PruneRule& rule);
// Throws Error for an unknown name, and for a rule that only cosplat-study registers.
PruneRule FindPruneRule(const std::string& name);
std::vector<std::string> PruneRuleNames();

// Null for "none". `schedule`, `iterations`: of the run. Throws Error if the settings do not fit
// the rule (such as a target count for a rule that has none).
std::unique_ptr<Pruner> MakePruner(const PruneSettings& settings,
                                   const Schedule& schedule,
                                   int iterations,
                                   size_t gaussians);

}  // namespace cosplat
