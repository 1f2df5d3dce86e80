#include "splat/render/cuda/device_gaussians.h"

namespace cosplat::cuda {

int DeviceGaussians::width(int attribute) const {
  Gaussians layout;
  layout.degree = degree;
  return layout.width(attribute);
}

void DeviceGaussians::Upload(const Gaussians& gaussians, cudaStream_t stream) {
  degree = gaussians.degree;
  degrees.Upload(gaussians.degrees.data(), gaussians.degrees.size(), stream);
  for (int a = 0; a < kAttributeCount; ++a)
    values[a].Upload(gaussians.values[a].data(), gaussians.values[a].size(), stream);
}

void DeviceGaussians::Download(Gaussians& gaussians, cudaStream_t stream) const {
  for (int a = 0; a < kAttributeCount; ++a) values[a].Download(gaussians.values[a].data(), stream);
}

void DeviceGaussians::ResizeLike(const DeviceGaussians& other) {
  degree = other.degree;
  for (int a = 0; a < kAttributeCount; ++a) values[a].Refill(other.values[a].size());
}

void DeviceGaussians::FillWithZeros(cudaStream_t stream) {
  for (DeviceBuffer<float>& v : values) v.FillWithZeros(stream);
}

WorldGaussians DeviceGaussians::View() const {
  WorldGaussians view;
  view.count = size();
  view.rest_width = width(kColorRest);
  view.position = values[kPosition].data();
  view.rotation = values[kRotation].data();
  view.scale_log = values[kScaleLog].data();
  view.opacity_logit = values[kOpacityLogit].data();
  view.color_dc = values[kColorDc].data();
  view.color_rest = values[kColorRest].data();
  if (!degrees.empty()) view.degree = degrees.data();
  return view;
}

WorldGradients DeviceGaussians::GradientView(DeviceBuffer<float>& screen) {
  screen.Refill(2 * size());
  WorldGradients view;
  view.position = values[kPosition].data();
  view.rotation = values[kRotation].data();
  view.scale_log = values[kScaleLog].data();
  view.opacity_logit = values[kOpacityLogit].data();
  view.color_dc = values[kColorDc].data();
  view.color_rest = values[kColorRest].data();
  view.screen = screen.data();
  return view;
}

}  // namespace cosplat::cuda
