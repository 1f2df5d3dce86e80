// Adaptive density control: where Gaussians are added and removed during training.
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
struct PruneRound;

// The order that density control leaves Gaussians in: entry i was source[i] before; from
// first_fresh on they are new: cloned or split off, their moments and statistics start at zero.
struct Reordering {
  View<const uint32_t> source;
  size_t first_fresh = 0;
};

// Gathered over the steps since the last densification; one entry per Gaussian.
struct DensityStatistics {
  Buffer<float> screen_gradient;  // sum of |dL/d(centre)| in normalised device coordinates
  Buffer<float> plasticity;       // sum of |dL/ds|
  Buffer<float> visible;          // steps in which it was drawn

  std::array<Buffer<float>*, 3> all() { return {&screen_gradient, &plasticity, &visible}; }
  void Reset(size_t n, Stream& stream = HostStream());
  // Of |dL/ds| over the steps in which it was drawn; 0 for one that was not.
  float MeanPlasticity(size_t i) const { return math::MeanWhereVisible(plasticity[i], visible[i]); }
  // radii: [N] 0 where not drawn; screen: [N, 2] dL/d(centre) per px; d_scale_log, scale_log:
  // [N, 3]. Nothing while *overflowed is not 0.
  void Accumulate(View<const float> radii,
                  View<const float> screen,
                  View<const float> d_scale_log,
                  View<const float> scale_log,
                  int width,
                  int height,
                  const uint32_t* overflowed,
                  Stream& stream);
  // As Gaussians' (splat/gaussians.h).
  void Upload(const DensityStatistics& from, Stream& stream);
  void Download(DensityStatistics& to, Stream& stream) const;
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

// Who draws for density control, between steps, in the memory that steps have anyway.
struct Canvas {
  Rasterizer& rasterizer;
  RenderedImage& image;
  RenderTape& tape;
};

// What density control must know of where Gaussians are: a static scene moves a point, an avatar
// re-embeds it on its mesh. Arrays are in the stream's memory.
class Placement {
 public:
  virtual ~Placement() = default;
  // Per-Gaussian data beside `Gaussians` follows the same reordering.
  virtual void Gather(View<const uint32_t> source, Stream& stream) {
    (void)source;
    (void)stream;
  }
  // Moves all Gaussians from `first` on by a row of `offsets` ([rows, 3]) each, in the frame that
  // kRotation and kScaleLog are in.
  virtual void Move(View<const float> offsets, size_t first, Gaussians& gaussians, Stream& stream);
  // [N, 3] where they are, in a frame in which near means near in every frame. Until the next call.
  virtual View<const float> Centers(const Gaussians& gaussians, Stream& stream) {
    (void)stream;
    return gaussians.values[kPosition].view();
  }
  // Group of each Gaussian for pruning, on the host; empty: one group. Waits.
  virtual std::vector<int32_t> Groups(Stream& stream) {
    (void)stream;
    return {};
  }
  // May veto removals (an avatar's holes): zeroes those of `unwanted` ([N], 1: goes) that stay.
  // canvas: null where nobody draws.
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

// All that is per Gaussian, so that reordering moves it alike. Adam must have caught up
// (splat/train/optimizer.h): Error otherwise, on the host.
struct Population {
  Placement& placement;
  Gaussians& gaussians;
  AdamState& adam;
  DensityStatistics& statistics;
  Gaussians& gradients;  // their memory takes turns with the others': any values afterwards
  Stream& stream;
  const Canvas* canvas = nullptr;
  Pruner* pruner = nullptr;     // or null: none has data of its own
  MaskLearner* mask = nullptr;  // likewise

  void Gather(const Reordering& order) const;
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

struct DensityReport {
  size_t cloned = 0, split = 0;
  bool held_back = false;  // by the limit on their number
};

// On the host or on a device: counted, places found by sums, gathered. Random numbers are drawn by
// index. Reuse one: it keeps its memory.
class DensityControl {
 public:
  // Clone, split, remove what is transparent, oversized or broken. The statistics go along.
  DensityReport Control(const DensitySettings& settings,
                        bool remove_oversized,
                        const Population& population,
                        Rng& rng);
  // What `unwanted` ([N], 1) marks goes, unless the placement vetoes it. Returns how many went.
  size_t Remove(View<uint8_t> unwanted, const Population& population);
  // What a round of pruning (splat/prune/pruner.h) and a cap of groups take goes. Returns how many.
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
  // Turns flags ([n + 1], the last 0) into where each of them goes; returns how many are set.
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

// Opacities above 0.01 are set to it, and their moments cleared (3DGS).
float ResetOpacityLogit();
void ResetOpacity(Gaussians& gaussians, AdamState& adam, Stream& stream = HostStream());

}  // namespace cosplat
