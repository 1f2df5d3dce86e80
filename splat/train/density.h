// Adaptive density control: where Gaussians are added and removed during training.
// Source: Kerbl et al. 2023, section 5; pruning: splat/prune/pruner.h.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "splat/base/rng.h"
#include "splat/gaussians.h"
#include "splat/train/kernels/density.h"
#include "splat/train/optimizer.h"

namespace cosplat {

class Pruner;
class RenderTape;
struct PruneRound;

// The order that density control leaves Gaussians in: entry i was source[i] before.
struct Reordering {
  std::vector<uint32_t> source;
  std::vector<uint32_t> fresh;  // entries that are new: cloned or split off, moments start at zero
};

// Gathered over the steps since the last densification; one entry per Gaussian.
struct DensityStatistics {
  Buffer<float> screen_gradient;  // sum of |dL/d(centre)| in normalised device coordinates
  Buffer<float> plasticity;       // sum of |dL/ds|
  Buffer<float> visible;          // steps in which it was drawn

  void Reset(size_t n);
  // Of |dL/ds| over the steps in which it was drawn; 0 for one that was not.
  float MeanPlasticity(size_t i) const { return math::MeanWhereVisible(plasticity[i], visible[i]); }
  // Those of new Gaussians are zero.
  void Gather(const Reordering& order);
  // `screen`: [N, 2] dL/d(centre) per px. d_scale_log, scale_log: [N, 3].
  void Accumulate(const RenderTape& tape,
                  const Buffer<float>& screen,
                  const Buffer<float>& d_scale_log,
                  const Buffer<float>& scale_log,
                  int width,
                  int height);
};

struct DensitySettings {
  float gradient_threshold = 2e-4f;  // mean screen gradient above which one is cloned or split
  float split_scale = 0.01f;         // above this standard deviation it is split; scene units
  float min_opacity = 0.005f;
  float max_scale = 0;  // larger ones are removed once size pruning is on; scene units
  // A clone and its original share the opacity (math::SharedOpacityLogit); in 3DGS both keep it.
  bool shares_opacity = false;
  size_t max_count = 2000000;  // never exceeded by adding: the strongest gradients go first
};

math::RemovalRule RemovalRuleOf(const DensitySettings& settings, bool remove_oversized);

struct DensityReport {
  size_t cloned = 0, split = 0, transparent = 0, oversized = 0, broken = 0;
};

// What density control must know of where Gaussians are: a static scene moves a point, an avatar
// re-embeds it on its mesh.
class Placement {
 public:
  virtual ~Placement() = default;
  // Per-Gaussian data beside `Gaussians` follows the same reordering.
  virtual void Gather(const std::vector<uint32_t>& source) { (void)source; }
  // Moves Gaussian i by `offset` (in the frame that kRotation and kScaleLog are in).
  virtual void Move(Gaussians& gaussians, uint32_t i, const std::array<float, 3>& offset);
  // Where Gaussian i is, in a frame in which near means near in every frame.
  virtual std::array<float, 3> Center(const Gaussians& gaussians, size_t i) const;
  // Group of each Gaussian for pruning; empty: one group.
  virtual std::vector<int32_t> Groups() const { return {}; }
  // May veto removals (an avatar's holes): erases from `removed` (ascending) those that must stay.
  virtual void Veto(const Gaussians& gaussians, std::vector<uint32_t>& removed) {
    (void)gaussians;
    (void)removed;
  }
};

// All that is per Gaussian, so that reordering moves it alike. Adam must have caught up
// (splat/train/optimizer.h): Error otherwise.
struct Population {
  Placement& placement;
  Gaussians& gaussians;
  AdamState& adam;
  DensityStatistics& statistics;
  Pruner* pruner = nullptr;  // or null: none has data of its own

  void Gather(const Reordering& order) const;
  // What `unwanted` ([N], 1) marks goes, unless the placement vetoes it. Returns how many went.
  size_t Remove(std::vector<uint8_t> unwanted) const;
  // What a round of pruning (splat/prune/pruner.h) and a cap of groups take goes. Returns how many.
  size_t Prune(const PruneRound& round, int group_cap, int group_floor) const;

 private:
  size_t Take(const std::vector<uint8_t>& unwanted) const;
};

// Puts those of `unwanted` ([N], 1) that must stay back to 0.
using Veto = std::function<void(std::vector<uint8_t>& unwanted)>;

// [count] 1: what such a round and cap take (Placement::Groups). In the place of what must stay the
// next of the ranking go, so that the round leaves as many as it was asked to: to one in a hundred
// or so, since what they leave may be vetoed again.
std::vector<uint8_t> UnwantedBy(const PruneRound& round,
                                size_t count,
                                const std::vector<int32_t>& groups,
                                int group_cap,
                                int group_floor,
                                const Veto& veto);

// Clone, split, remove what is transparent, oversized or broken. The statistics go along.
DensityReport ControlDensity(const DensitySettings& settings,
                             bool remove_oversized,
                             const Population& population,
                             Rng& rng);

// Puts the Gaussians in Morton order (splat/train/morton.h).
void SortInSpace(const Population& population);

// Opacities above 0.01 are set to it, and their moments cleared (3DGS).
float ResetOpacityLogit();
void ResetOpacity(Gaussians& gaussians, AdamState& adam);

}  // namespace cosplat
