#include "splat/bench/synthetic_view.h"

#include <algorithm>
#include <cmath>

#include "splat/base/image_io.h"
#include "splat/base/rng.h"
#include "splat/config.h"
#include "splat/rasterizer.h"

namespace cosplat {
namespace {

constexpr float kPi = 3.14159265f;
constexpr float kMeanOpacity = 0.3f;

Camera CameraFor(int width, int height) {
  Camera c;
  c.width = width;
  c.height = height;
  c.fx = c.fy = float(std::max(width, height));
  c.cx = 0.5f * float(width);
  c.cy = 0.5f * float(height);
  return c;
}

// Standard deviation, px, with which `count` splats of the mean opacity cover the image
// kSyntheticLayers times with an alpha of at least kMinAlpha, before the low-pass filter.
float SigmaPx(size_t count, const Camera& camera) {
  const double area = kSyntheticLayers * camera.width * camera.height / double(count);
  const double variance = area / (2 * kPi * std::log(kMeanOpacity / kMinAlpha)) - kBlurVariance;
  constexpr double kLeastVariance = 0.01;
  return float(std::sqrt(std::max(kLeastVariance, variance)));
}

Gaussians Spread(size_t count, const Camera& camera, Rng& rng) {
  const float sigma_px = SigmaPx(count, camera);
  Gaussians g;
  g.degree = 3;
  g.Resize(count);
  for (size_t i = 0; i < count; ++i) {
    const float depth = 2 + 2 * rng.Uniform(), per_px = depth / camera.fx;
    float* p = g.at(kPosition, i);
    p[0] = (rng.Uniform() - 0.5f) * float(camera.width) * per_px;
    p[1] = (rng.Uniform() - 0.5f) * float(camera.height) * per_px;
    p[2] = depth;
    for (int k = 0; k < 4; ++k) g.at(kRotation, i)[k] = rng.Normal();
    for (int k = 0; k < 3; ++k) {
      g.at(kScaleLog, i)[k] = std::log(sigma_px * per_px) + 0.2f * rng.Normal();
      g.at(kColorDc, i)[k] = rng.Normal();
    }
    const float opacity = kMeanOpacity * (0.5f + rng.Uniform());
    *g.at(kOpacityLogit, i) = std::log(opacity / (1 - opacity));
    for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = 0.05f * rng.Normal();
  }
  return g;
}

// Moved by a fraction of their size and recoloured, so that every gradient is at work.
void Displace(Gaussians& g, Rng& rng) {
  for (size_t i = 0; i < g.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      g.at(kPosition, i)[k] += 0.3f * std::exp(g.at(kScaleLog, i)[k]) * rng.Normal();
      g.at(kColorDc, i)[k] += 0.2f * rng.Normal();
    }
}

}  // namespace

SyntheticView MakeSyntheticView(size_t count, int width, int height, uint64_t seed) {
  Rng rng{seed};
  SyntheticView view;
  view.frame.camera = CameraFor(width, height);
  view.start = Spread(std::max<size_t>(1, count), view.frame.camera, rng);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(ViewOf(view.start),
                      view.start.basis,
                      view.frame.camera,
                      {{0, 0, 0}, view.start.degree},
                      image,
                      *tape);
  view.frame.target = ToBytes(image.ToImage());
  Displace(view.start, rng);
  return view;
}

}  // namespace cosplat
