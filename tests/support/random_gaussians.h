// Gaussians around the origin with every attribute at random, and an image of them.
#pragma once

#include <cmath>

#include "splat/base/rng.h"
#include "splat/render/rasterizer.h"

namespace cosplat::test {

// Those that files can hold at every degree.
constexpr Basis kHarmonicBases[] = {Basis::kDcsh, Basis::kSh, Basis::kDcshReleased};

inline Gaussians RandomGaussians(size_t n, int degree, Basis basis, uint64_t seed) {
  Rng rng{seed};
  Gaussians g;
  g.degree = degree;
  g.basis = basis;
  g.Resize(n);
  for (size_t i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      g.at(kPosition, i)[k] = 0.5f * rng.Normal();
      g.at(kScaleLog, i)[k] = std::log(0.12f) + 0.4f * rng.Normal();
      g.at(kColorDc, i)[k] = rng.Normal();
    }
    for (int k = 0; k < 4; ++k) g.at(kRotation, i)[k] = rng.Normal();
    *g.at(kOpacityLogit, i) = rng.Normal();
    for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = 0.1f * rng.Normal();
  }
  return g;
}

inline RenderedImage Image(const WorldGaussians& gaussians,
                           Basis basis,
                           int degree,
                           const Camera& camera) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(gaussians, basis, camera, {{0.3f, 0.5f, 0.7f}, degree}, image, *tape);
  return image;
}
inline RenderedImage Image(const Gaussians& g, const Camera& camera) {
  return Image(ViewOf(g), g.basis, g.degree, camera);
}

// Largest difference of any channel of any pixel.
inline float LargestDifference(const RenderedImage& a, const RenderedImage& b) {
  float largest = a.color.size() == b.color.size() ? 0.0f : INFINITY;
  for (size_t i = 0; i < a.color.size() && i < b.color.size(); ++i)
    largest = std::max(largest, std::abs(a.color[i] - b.color[i]));
  return largest;
}

}  // namespace cosplat::test
