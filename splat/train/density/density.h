// Adaptive density control: adds and removes Gaussians during training.
// Source: Kerbl et al. 2023, section 5; pruning: splat/prune/pruner.h.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "splat/base/rng.h"
#include "splat/device/sort.h"
#include "splat/gaussians.h"
#include "splat/render/rasterizer.h"
#include "splat/train/kernels/density.h"
#include "splat/train/morton.h"
#include "splat/train/optimizer.h"

namespace cosplat {

class MaskLearner;
class Pruner;
class Shards;
struct PruneRound;

// How density control reorders Gaussians: entry i was source[i] before. Entries from first_fresh on
// are new (cloned or split off); their moments and statistics start at zero.
struct Reordering {
  View<const uint32_t> source;
  size_t first_fresh = 0;
};

// Accumulated over the steps since the last densification; one entry per Gaussian.
struct DensityStatistics {
  Buffer<float> screen_gradient;  // sum of |dL/d(centre)| in normalised device coordinates
  Buffer<float> plasticity;       // sum of |dL/ds|
  Buffer<float> visible;          // number of steps in which it was visible

  std::array<Buffer<float>*, 3> all() { return {&screen_gradient, &plasticity, &visible}; }
  void Reset(size_t n, Stream& stream = HostStream());
  // Mean of |dL/ds| over the steps in which the Gaussian was visible; 0 if there were none.
  float MeanPlasticity(size_t i) const { return math::MeanWhereVisible(plasticity[i], visible[i]); }
  // radii: [N], 0 where invisible; screen: [N, 2] dL/d(centre) per px;
  // d_scale_log, scale_log: [N, 3]. Does nothing if *overflowed is not 0.
  void Accumulate(View<const float> radii,
                  View<const float> screen,
                  View<const float> d_scale_log,
                  View<const float> scale_log,
                  int width,
                  int height,
                  const uint32_t* overflowed,
                  Stream& stream);
  // Same as those of Gaussians (splat/gaussians.h).
  void Upload(const DensityStatistics& from, Stream& stream);
  void Download(DensityStatistics& to, Stream& stream) const;
};

struct DensitySettings {
  float gradient_threshold = 2e-4f;  // clone or split above this mean screen gradient
  float split_scale = 0.01f;         // split, not clone, above this standard deviation; scene units
  float min_opacity = 0.005f;
  float max_scale = 0;  // larger Gaussians are removed once size pruning is on; scene units
  // A clone and its original share the opacity (math::SharedOpacityLogit); in 3DGS both keep it.
  bool shares_opacity = false;
  size_t max_count = 2000000;  // densification stops there; the strongest gradients come first
};

math::RemovalRule RemovalRuleOf(const DensitySettings& settings, bool remove_oversized);

// The renderer that density control may use between steps, with the steps' own buffers.
struct Canvas {
  Rasterizer& rasterizer;
  RenderedImage& image;
  RenderTape& tape;
};

// How density control moves and locates Gaussians: a static scene moves a point, an avatar
// re-embeds it on its mesh. Arrays are in the stream's memory.
class Placement {
 public:
  virtual ~Placement() = default;
  // Applies the same reordering to per-Gaussian data outside `Gaussians`.
  virtual void Gather(View<const uint32_t> source, Stream& stream) {
    (void)source;
    (void)stream;
  }
  // Moves each Gaussian from `first` on by one row of `offsets` ([rows, 3]), in the frame that
  // kRotation and kScaleLog refer to.
  virtual void Move(View<const float> offsets, size_t first, Gaussians& gaussians, Stream& stream);
  // [N, 3] positions in a coordinate frame where Gaussians that are close are close in every
  // training frame. Valid until the next call.
  virtual View<const float> Centers(const Gaussians& gaussians, Stream& stream) {
    (void)stream;
    return gaussians.values[kPosition].view();
  }
  // Group of each Gaussian for pruning, on the host; empty: a single group. Waits for the stream.
  virtual std::vector<int32_t> Groups(Stream& stream) {
    (void)stream;
    return {};
  }
  // May veto removals (that would tear holes into an avatar): resets the flags in `unwanted`
  // ([N], 1: remove) of Gaussians that must stay. canvas: null if nothing can be rendered.
  virtual void Veto(const Gaussians& gaussians,
                    const Canvas* canvas,
                    View<uint8_t> unwanted,
                    Stream& stream) {
    (void)gaussians;
    (void)canvas;
    (void)unwanted;
    (void)stream;
  }
};

// All per-Gaussian data, so that a reordering applies to all of it. Adam must have caught up
// (splat/train/optimizer.h); on the host, Error is thrown otherwise.
struct Population {
  Placement& placement;
  Gaussians& gaussians;
  AdamState& adam;
  DensityStatistics& statistics;
  Gaussians& gradients;  // used as swap memory: any values afterwards
  Stream& stream;
  const Canvas* canvas = nullptr;
  Pruner* pruner = nullptr;     // null: no pruner with data of its own
  MaskLearner* mask = nullptr;  // likewise
  // Where Gaussians are divided between ranks: `adam` has the moments of this rank's own, and
  // kColorRest of `own` replaces that of `gaussians`. Null: they are not.
  Shards* shards = nullptr;
  Gaussians* own = nullptr;

  void Gather(const Reordering& order) const;
};

// Resets the flags in `unwanted` ([N], 1: remove) of Gaussians that must stay.
using Veto = std::function<void(std::vector<uint8_t>& unwanted)>;

// [count] flags, 1 for the Gaussians that a round of pruning and the cap per group remove (groups:
// Placement::Groups). Vetoed Gaussians are replaced by the next ones in the ranking, so that the
// round leaves the requested number to within about one in a hundred, as the replacements may be
// vetoed too.
std::vector<uint8_t> UnwantedBy(const PruneRound& round,
                                size_t count,
                                const std::vector<int32_t>& groups,
                                int group_cap,
                                int group_floor,
                                const Veto& veto);

struct DensityReport {
  size_t cloned = 0, split = 0;
  bool held_back = false;  // limited by max_count
};

// Runs on the host or on a device: count, find output positions by prefix sums, gather. Random
// numbers are generated by index. Reuse one instance: it keeps its memory.
class DensityControl {
 public:
  // Clones and splits, then removes transparent, oversized and non-finite Gaussians. The statistics
  // are reordered along with them.
  DensityReport Control(const DensitySettings& settings,
                        bool remove_oversized,
                        const Population& population,
                        Rng& rng);
  // Removes the Gaussians that `unwanted` ([N], 1: remove) marks, unless the placement vetoes it.
  // Returns the number removed.
  size_t Remove(View<uint8_t> unwanted, const Population& population);
  // Removes the Gaussians that a round of pruning (splat/prune/pruner.h) and the cap per group
  // select. Returns the number removed.
  size_t Prune(const PruneRound& round,
               int group_cap,
               int group_floor,
               const Population& population);
  // Puts the Gaussians in Morton order (splat/train/morton.h).
  void SortInSpace(const Population& population);
  size_t held() const;  // bytes
  void Release() { *this = DensityControl(); }

 private:
  size_t Select(const DensitySettings& settings, const Population& population);
  void KeepStrongest(size_t room, Stream& stream);
  DensityReport AddChildren(const Population& population, Rng& rng);
  size_t Take(View<const uint8_t> unwanted, const Population& population);
  // Turns flags ([n + 1], the last 0) into output positions; returns the number of set flags.
  size_t PlacesOf(Buffer<uint64_t>& flags, Stream& stream);

  Buffer<float> mean_;    // [N] screen gradients
  Buffer<uint8_t> kind_;  // [N] DensityKind
  Buffer<uint8_t> unwanted_;
  Buffer<uint64_t> kept_, cloned_, split_;  // [N + 1]
  Buffer<uint32_t> source_;
  Buffer<float> offsets_;  // [children, 3]
  KeyedValues order_;
  MortonSort morton_;
};

// Opacity reset: lowers opacities above 0.01 to that value and clears their moments (3DGS).
float ResetOpacityLogit();
void ResetOpacity(Gaussians& gaussians, AdamState& adam, Stream& stream = HostStream());

}  // namespace cosplat
