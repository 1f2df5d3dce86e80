// Adaptive density control: where Gaussians are added and removed during training.
// Source: Kerbl et al. 2023, section 5; pruning by plasticity: splat/prune.h.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/base/rng.h"
#include "splat/gaussians.h"
#include "splat/optimizer.h"

namespace cosplat {

class RenderTape;

// Gathered over the steps since the last densification; one entry per Gaussian.
struct DensityStatistics {
  Buffer<float> screen_gradient;  // sum of |dL/d(centre)| in normalised device coordinates
  Buffer<float> plasticity;       // sum of |dL/ds|
  Buffer<float> visible;          // steps in which it was drawn
  Buffer<float> max_radius;       // px, the largest so far

  void Reset(size_t n);
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
  float max_scale = 0;         // larger ones are removed once size pruning is on; scene units
  float max_radius_px = 20;    // likewise
  size_t max_count = 2000000;  // never exceeded by adding: the strongest gradients go first

  bool prune_by_plasticity = false;
  float prune_fraction = 0.02f;  // share removed at each densification
  size_t prune_to = 0;           // or, when not 0: towards this count by the last one
  int group_cap = 0;
  int group_floor = 0;
};

struct DensityReport {
  size_t cloned = 0, split = 0, transparent = 0, oversized = 0, unplastic = 0, broken = 0;
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
  // May veto removals (an avatar's holes): erases from `removed` those that must stay.
  virtual void Veto(const Gaussians& gaussians, std::vector<uint32_t>& removed) {
    (void)gaussians;
    (void)removed;
  }
};

// Clone, split, remove; then clears the statistics. New Gaussians start with zero moments. Adam
// must have caught up (splat/optimizer.h): Error otherwise.
DensityReport ControlDensity(const DensitySettings& settings,
                             bool remove_oversized,
                             int rounds_left,
                             Placement& placement,
                             Gaussians& gaussians,
                             AdamState& adam,
                             DensityStatistics& statistics,
                             Rng& rng);

// Puts the Gaussians in Morton order (splat/morton.h). The statistics must be clear, and Adam have
// caught up.
void SortInSpace(Placement& placement, Gaussians& gaussians, AdamState& adam);

// Opacities above 0.01 are set to it, and their moments cleared (3DGS).
void ResetOpacity(Gaussians& gaussians, AdamState& adam);

}  // namespace cosplat
