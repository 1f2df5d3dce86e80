// What density control and pruning know of the steps since the last densification.
#pragma once

#include <array>
#include <cstdint>

#include "splat/device/buffer.h"
#include "splat/train/state/kernels/statistics.h"

namespace cosplat {

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

  // As in splat/device/arrays.h.
  template <class Visit, class... Of>
  static void ForEachArray(const Visit& visit, Of&... of) {
    visit("screen_gradient", size_t(1), of.screen_gradient...);
    visit("plasticity", size_t(1), of.plasticity...);
    visit("visible", size_t(1), of.visible...);
  }
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
};

}  // namespace cosplat
