#include "splat/train/state/density_statistics.h"

#include "splat/device/for_each.h"

namespace cosplat {

void DensityStatistics::Reset(size_t n, Stream& stream) {
  for (Buffer<float>* b : all()) {
    b->Refill(n, stream);
    b->FillWithZeros(stream);
  }
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

void DensityStatistics::Upload(const DensityStatistics& from, Stream& stream) {
  screen_gradient.Upload(from.screen_gradient.data(), from.screen_gradient.size(), stream);
  plasticity.Upload(from.plasticity.data(), from.plasticity.size(), stream);
  visible.Upload(from.visible.data(), from.visible.size(), stream);
}

void DensityStatistics::Download(DensityStatistics& to, Stream& stream) const {
  to.Reset(visible.size());
  screen_gradient.Download(to.screen_gradient.data(), stream);
  plasticity.Download(to.plasticity.data(), stream);
  visible.Download(to.visible.data(), stream);
}

}  // namespace cosplat
