#include "apps/study/bench/synthetic_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "splat/base/rng.h"
#include "splat/config.h"
#include "splat/math/scalar.h"
#include "splat/media/image_io.h"
#include "splat/render/rasterizer.h"

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

// Standard deviation, px, with which `count` splats of mean opacity cover the image
// kSyntheticLayers times with an alpha of at least kMinAlpha, before the low-pass filter.
float SigmaPx(size_t count, const Camera& camera) {
  const double area = kSyntheticLayers * camera.width * camera.height / double(count);
  const double variance = area / (2 * kPi * std::log(kMeanOpacity / kMinAlpha)) - kBlurVariance;
  constexpr double kMinVariance = 0.01;
  return float(std::sqrt(std::max(kMinVariance, variance)));
}

// Standard deviations along a Gaussian's axes, px at its depth, and its opacity.
struct Shape {
  std::array<float, 3> sigma_px;
  float opacity;
};

Shape DrawRound(float sigma_px, Rng& rng) {
  Shape shape;
  for (float& s : shape.sigma_px) s = sigma_px * std::exp(0.2f * rng.Normal());
  shape.opacity = kMeanOpacity * (0.5f + rng.Uniform());
  return shape;
}

// Half of the Gaussians in a trained scene are needle-like, the other half discs: the thinnest axis
// is far below a pixel, and for every second one so is the middle axis. Lengths and opacities are
// distributed roughly as in a chair trained at 800x800 for 30,000 steps: the longest axis has a
// median of 1.8 px and a 90th percentile of 7.5 px, the opacity's quartiles are 0.10, 0.31 and
// 0.67.
Shape DrawTrained(Rng& rng) {
  constexpr float kThin = 0.003f;  // px
  const float longest = 1.84f * std::exp(1.1f * rng.Normal());
  const float middle = rng.Uniform() < 0.5f ? kThin : std::exp(0.9f * rng.Normal());
  const float logit = -0.8f + 2.3f * rng.Normal();
  return {{longest, std::min(middle, longest), kThin}, 1 / (1 + std::exp(-logit))};
}

template <class DrawShape>
Gaussians Spread(size_t count, const Camera& camera, Rng& rng, const DrawShape& draw) {
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
    const Shape shape = draw(rng);
    for (int k = 0; k < 3; ++k) {
      g.at(kScaleLog, i)[k] = std::log(shape.sigma_px[k] * per_px);
      g.at(kColorDc, i)[k] = rng.Normal();
    }
    *g.at(kOpacityLogit, i) = math::Logit(shape.opacity);
    for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = 0.05f * rng.Normal();
  }
  return g;
}

// Moved by a fraction of their size and recoloured, so that no gradient is zero.
void Displace(Gaussians& g, Rng& rng) {
  for (size_t i = 0; i < g.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      g.at(kPosition, i)[k] += 0.3f * std::exp(g.at(kScaleLog, i)[k]) * rng.Normal();
      g.at(kColorDc, i)[k] += 0.2f * rng.Normal();
    }
}

// Renders the frame from `start`, then displaces `start`.
SyntheticView RenderedView(Gaussians start, const Camera& camera, Rng& rng) {
  SyntheticView view;
  view.frame.camera = camera;
  view.start = std::move(start);
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

}  // namespace

SyntheticView MakeSyntheticView(size_t count, int width, int height, uint64_t seed) {
  Rng rng{seed};
  const Camera camera = CameraFor(width, height);
  count = std::max<size_t>(1, count);
  const float sigma_px = SigmaPx(count, camera);
  return RenderedView(
      Spread(count, camera, rng, [=](Rng& r) { return DrawRound(sigma_px, r); }), camera, rng);
}

SyntheticView MakeTrainedView(int width, int height, uint64_t seed) {
  Rng rng{seed};
  const Camera camera = CameraFor(width, height);
  const auto count = std::max<size_t>(1, size_t(kTrainedPerPixel * width * height));
  return RenderedView(Spread(count, camera, rng, DrawTrained), camera, rng);
}

}  // namespace cosplat
