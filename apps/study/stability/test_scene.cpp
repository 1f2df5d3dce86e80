#include "apps/study/stability/test_scene.h"

#include <algorithm>
#include <cmath>

#include "splat/base/rng.h"
#include "splat/basis_constants.h"
#include "splat/math/scalar.h"

namespace cosplat {
namespace {}  // namespace

float PixelWeight(size_t i) { return 0.6f + 0.4f * std::sin(0.7f * float(i)); }

Camera StraightCamera(int side) {
  Camera c;
  c.width = c.height = side;
  c.fx = c.fy = float(side);
  c.cx = c.cy = 0.5f * float(side);
  return c;
}

Camera Turned(const Camera& camera, double rad) {
  const float c = float(std::cos(rad)), s = float(std::sin(rad));
  const float turn[9] = {c, 0, -s, 0, 1, 0, s, 0, c};
  Camera turned = camera;
  for (int i = 0; i < 3; ++i) {
    turned.translation[i] = 0;
    for (int k = 0; k < 3; ++k) {
      turned.translation[i] += turn[3 * i + k] * camera.translation[k];
      turned.rotation[3 * i + k] = 0;
      for (int j = 0; j < 3; ++j)
        turned.rotation[3 * i + k] += turn[3 * i + j] * camera.rotation[3 * j + k];
    }
  }
  return turned;
}

Gaussians RandomBlobs(size_t count, float depth, uint64_t seed, float scale) {
  Rng rng{seed};
  Gaussians g;
  g.degree = 1;
  g.Resize(count);
  for (size_t i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) {
      g.at(kPosition, i)[k] = 0.3f * rng.Normal() + (k == 2 ? depth : 0);
      g.at(kScaleLog, i)[k] = std::log(scale) + 0.4f * rng.Normal();
      g.at(kColorDc, i)[k] = 3.4f * (rng.Uniform() - 0.5f);
    }
    for (int k = 0; k < 4; ++k) g.at(kRotation, i)[k] = rng.Normal();
    *g.at(kOpacityLogit, i) = math::Logit(0.8f);
    for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = 0.06f * rng.Normal();
  }
  return g;
}

void Append(const Blob& blob, Gaussians& g) {
  const size_t i = g.size();
  g.Resize(i + 1);
  g.at(kRotation, i)[0] = 1;
  *g.at(kOpacityLogit, i) = math::Logit(blob.opacity);
  for (int k = 0; k < 3; ++k) {
    g.at(kPosition, i)[k] = blob.position[k];
    g.at(kScaleLog, i)[k] = std::log(blob.scale);
    g.at(kColorDc, i)[k] = (blob.color[k] - 0.5f) / BasisConstants(g.basis)[0];
  }
}

RenderedImage Draw(const Gaussians& g, const Camera& camera) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(ViewOf(g), g.basis, camera, {{0, 0, 0}, g.degree}, image, *tape);
  return image;
}

DrawnBothWays DrawBothWays(const Gaussians& g, const Camera& camera) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  DrawnBothWays drawn;
  RenderedImage& image = drawn.image;
  rasterizer->Forward(ViewOf(g), g.basis, camera, {{0, 0, 0}, g.degree}, image, *tape);
  Buffer<float> d_color(image.color.size()), screen;
  for (size_t i = 0; i < d_color.size(); ++i) d_color[i] = PixelWeight(i);
  drawn.gradients = g.ZerosLike();
  rasterizer->Backward(ViewOf(g), image, d_color, *tape, GradientViewOf(drawn.gradients, screen));
  return drawn;
}

double WeighedSum(const RenderedImage& image) {
  double sum = 0;
  for (size_t i = 0; i < image.color.size(); ++i)
    sum += double(image.color[i]) * double(PixelWeight(i));
  return sum;
}

size_t CountNotFinite(const Gaussians& gradients) {
  size_t count = 0;
  for (const auto& values : gradients.values)
    count += size_t(
        std::count_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); }));
  return count;
}

}  // namespace cosplat
