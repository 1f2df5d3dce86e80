// Pruning: training removes Gaussians beyond those that density control removes (transparent,
// oversized). Each rule has its own file; rules rank the Gaussians, and the lowest are removed.
//
//   step (with its Mask) -> AfterBackward -> density control -> PrunesAt? -> Rank -> removal
//
// docs/study.md lists the rules and their source papers.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "splat/base/rng.h"
#include "splat/base/state_file.h"
#include "splat/gaussians.h"
#include "splat/train/optimize/schedule.h"
#include "splat/train/prune/importance.h"
#include "splat/train/prune/learned_mask.h"
#include "splat/train/prune/settings.h"
#include "splat/train/state/density_statistics.h"

namespace cosplat {

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
};

class Pruner {
 public:
  virtual ~Pruner() = default;

  // Whether there is a pruning round after step `iteration`.
  virtual bool PrunesAt(int iteration) const = 0;
  // Ranks the Gaussians that remain after density control.
  virtual PruneRound Rank(const PruneContext& context) = 0;

  // Called after a step's gradients and before Adam, on the host (WorksOnProcessorOnly). radii: [N]
  // 0 where not rendered.
  virtual void AfterBackward(const Gaussians& gaussians,
                             const Gaussians& gradients,
                             View<const float> radii) {
    (void)gaussians;
    (void)gradients;
    (void)radii;
  }
  // The mask to learn in every step; empty if the rule learns none, or none at present.
  virtual MaskInSteps Mask() { return {}; }
  virtual void BeforeDensification() {}
  // Bytes allocated by the rule.
  virtual size_t Held() const { return 0; }
  // Writes what the rule keeps between steps to a checkpoint, or reads it, for `count` Gaussians.
  virtual void Describe(StateArchive& archive, size_t count) {
    (void)archive;
    (void)count;
  }
  // Reorders the rule's per-Gaussian data, on the host.
  virtual void Gather(const Reordering& order) { (void)order; }
};

// Null for PruneRule::kNone. `schedule`, `iterations`: of the run. Throws Error if the settings do
// not fit the rule (such as a target count for a rule that has none).
std::unique_ptr<Pruner> MakePruner(const PruneSettings& settings,
                                   const Schedule& schedule,
                                   int iterations,
                                   size_t gaussians);

}  // namespace cosplat
