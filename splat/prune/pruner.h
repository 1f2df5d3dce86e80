// Pruning: which Gaussians training takes away beyond those that density control does (transparent,
// oversized). One rule a file; all of them rank, and the lowest go.
//
//   step (with its Mask) -> AfterBackward -> density control -> PrunesAt? -> Rank -> removal
//
// Rules, with the papers they are made after: docs/study.md.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "splat/base/rng.h"
#include "splat/gaussians.h"
#include "splat/prune/learned_mask.h"
#include "splat/prune/settings.h"
#include "splat/train/density.h"
#include "splat/train/importance.h"
#include "splat/train/schedule.h"

namespace cosplat {

// What a pruner sees of the run when it ranks.
struct PruneContext {
  int iteration = 0;                    // of the step just done, from 1
  FrameImages& images;                  // of training frames
  View<const uint32_t> frames;          // that are trained on
  const Gaussians& gaussians;           // coefficients of bands 1.. may be others, on a device
  const DensityStatistics& statistics;  // since the last densification
  int degree = 0;                       // bands in use
  std::array<float, 3> background{0, 0, 0};
  Rng& rng;
};

struct PruneRound {
  std::vector<float> score;     // [N] lowest go first
  std::vector<uint8_t> exempt;  // [N] 1: not to be judged yet; or empty
  size_t remove = 0;            // how many go
};

class Pruner {
 public:
  virtual ~Pruner() = default;

  // Whether there is a round after step `iteration`.
  virtual bool PrunesAt(int iteration) const = 0;
  // Of the Gaussians as density control has left them.
  virtual PruneRound Rank(const PruneContext& context) = 0;

  // After a step's gradients, before Adam, on the host (WorksOnProcessorOnly). radii: [N] 0 where
  // not drawn.
  virtual void AfterBackward(const Gaussians& gaussians,
                             const Gaussians& gradients,
                             View<const float> radii) {
    (void)gaussians;
    (void)gradients;
    (void)radii;
  }
  // The mask that the rule has learned in every step; none for a rule that learns none, or not now.
  virtual MaskInSteps Mask() { return {}; }
  virtual void BeforeDensification() {}
  // Bytes that the rule holds.
  virtual size_t Held() const { return 0; }
  // The rule's own data per Gaussian follows, on the host.
  virtual void Gather(const Reordering& order) { (void)order; }
};

// Null for PruneRule::kNone. `schedule`, `iterations`: of the run. Throws Error when the settings
// do not fit the rule (a count for one that has none).
std::unique_ptr<Pruner> MakePruner(const PruneSettings& settings,
                                   const Schedule& schedule,
                                   int iterations,
                                   size_t gaussians);

}  // namespace cosplat
