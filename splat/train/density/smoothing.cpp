#include "splat/train/density/smoothing.h"

#include <utility>

#include "splat/device/for_each.h"
#include "splat/render/kernels/project.h"
#include "splat/train/density/kernels/smoothing.h"

namespace cosplat {

void SamplingFilter::Find(const Subject& subject, Gaussians& gaussians, Stream& stream) {
  if (views_.empty()) {
    Buffer<math::Pinhole<float>> views;
    for (size_t i = 0; i < subject.frame_count(); ++i)
      views.push_back(math::ToPinhole<float>(ViewOfCamera(subject.camera(i), {}, 0)));
    views_.Upload(views, stream);
    stream.Wait();
  }
  gaussians.smoothing.Refill(gaussians.size(), stream);
  ForEach(gaussians.size(),
          stream,
          FindSmoothing{std::as_const(views_).view(),
                        std::as_const(gaussians.values[kPosition]).view(),
                        gaussians.smoothing.view()});
}

}  // namespace cosplat
