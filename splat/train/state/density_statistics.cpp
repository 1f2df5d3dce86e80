#include "splat/train/state/density_statistics.h"

#include <string>

#include "splat/device/for_each.h"

namespace cosplat {

void DensityStatistics::Reset(size_t n, Stream& stream) {
  ForEachArray(
      [&](const std::string&, size_t, Buffer<float>& array) {
        array.Refill(n, stream);
        array.FillWithZeros(stream);
      },
      *this);
}

void DensityStatistics::Accumulate(View<const float> radii,
                                   View<const float> screen,
                                   View<const float> d_scale_log,
                                   View<const float> scale_log,
                                   int width,
                                   int height,
                                   const uint32_t* overflowed,
                                   Stream& stream) {
  ForEach(visible.size(),
          stream,
          AccumulateStep{radii,
                         screen,
                         d_scale_log,
                         scale_log,
                         width,
                         height,
                         screen_gradient.view(),
                         plasticity.view(),
                         visible.view(),
                         overflowed});
}

}  // namespace cosplat
