#include "splat/render/rasterizer.h"

#include <array>
#include <string>

#include "splat/base/error.h"
#include "splat/basis_constants.h"

namespace cosplat {

Image RenderedImage::ToImage() const {
  Image out(width, height, 3);
  const size_t plane = out.pixels();
  for (size_t i = 0; i < plane; ++i)
    for (int c = 0; c < 3; ++c) out.data[3 * i + c] = color[c * plane + i];
  return out;
}

Image RenderedImage::ToStraightAlpha() const {
  Image out(width, height, 4);
  const size_t plane = out.pixels();
  for (size_t i = 0; i < plane; ++i) {
    const float alpha = 1 - transmittance[i];
    for (int c = 0; c < 3; ++c)
      out.data[4 * i + c] = alpha > 0 ? color[c * plane + i] / alpha : 0.0f;
    out.data[4 * i + 3] = alpha;
  }
  return out;
}

void RenderedImage::Upload(const RenderedImage& host, Stream& stream) {
  width = host.width;
  height = host.height;
  color.Upload(host.color, stream);
  transmittance.Upload(host.transmittance, stream);
}

void RenderedImage::Download(RenderedImage& host, Stream& stream) const {
  host.width = width;
  host.height = height;
  color.Download(host.color, stream);
  transmittance.Download(host.transmittance, stream);
}

WorldGaussians ViewOf(const Gaussians& g) {
  WorldGaussians view;
  view.count = g.size();
  view.rest_width = g.width(kColorRest);
  view.position = g.values[kPosition].data();
  view.rotation = g.values[kRotation].data();
  view.scale_log = g.values[kScaleLog].data();
  view.opacity_logit = g.values[kOpacityLogit].data();
  view.color_dc = g.values[kColorDc].data();
  view.color_rest = g.values[kColorRest].data();
  if (!g.degrees.empty()) view.degree = g.degrees.data();
  if (!g.smoothing.empty()) view.smoothing = g.smoothing.data();
  view.antialiased = g.antialiased;
  view.low_pass_variance = g.low_pass_variance;
  return view;
}

WorldGradients GradientViewOf(Gaussians& d, Buffer<float>& screen, Stream& stream) {
  screen.Refill(2 * d.size(), stream);
  WorldGradients view;
  view.position = d.values[kPosition].data();
  view.rotation = d.values[kRotation].data();
  view.scale_log = d.values[kScaleLog].data();
  view.opacity_logit = d.values[kOpacityLogit].data();
  view.color_dc = d.values[kColorDc].data();
  view.color_rest = d.values[kColorRest].data();
  view.screen = screen.data();
  return view;
}

ViewParameters ViewOfCamera(const Camera& camera, Basis basis, int degree) {
  ViewParameters v{};
  for (int i = 0; i < 9; ++i) v.rotation[i] = camera.rotation[i];
  const std::array<float, 3> center = camera.Center();
  for (int i = 0; i < 3; ++i) {
    v.translation[i] = camera.translation[i];
    v.center[i] = center[i];
  }
  v.fx = camera.fx;
  v.fy = camera.fy;
  v.cx = camera.cx;
  v.cy = camera.cy;
  v.width = float(camera.width);
  v.height = float(camera.height);
  v.near_plane = camera.near_plane;
  v.basis_constants = BasisConstants(basis);
  v.folds_direction = FoldsDirection(basis);
  v.degree = degree;
  return v;
}

void CheckArguments(const WorldGaussians& gaussians,
                    const Camera& camera,
                    const RenderSettings& settings) {
  if (camera.width < 1 || camera.height < 1)
    throw Error("camera", "image of " + SizeText(camera.width, camera.height) + " pixels");
  if (3 * (CoefficientCount(settings.degree) - 1) > gaussians.rest_width ||
      settings.degree > kMaxTrainedDegree)
    throw Error("degree",
                std::to_string(settings.degree) + " exceeds the degree stored in the Gaussians");
  if (settings.exp_degree < kMinExpDegree || settings.exp_degree > kMaxExpDegree)
    throw Error("exp_degree",
                std::to_string(settings.exp_degree) + " is not between " +
                    std::to_string(kMinExpDegree) + " and " + std::to_string(kMaxExpDegree));
}

}  // namespace cosplat
