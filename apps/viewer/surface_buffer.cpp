#include "apps/viewer/surface_buffer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace cosplat::viewer {
namespace {

constexpr int kBandRows = 32;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

constexpr std::array<float, 3> kLamp{-0.29f, -0.48f, -0.83f};  // towards the lamp, above left
constexpr float kAmbient = 0.55f;

// Chosen by eye for an even increase in lightness.
constexpr std::array<std::array<float, 3>, 6> kAnchors{
    {{52, 24, 106}, {48, 78, 150}, {30, 128, 142}, {58, 176, 112}, {160, 212, 58}, {250, 232, 60}}};

}  // namespace

void SurfaceBuffer::Clear(int image_width, int image_height) {
  width = image_width * kSamplesPerSide;
  height = image_height * kSamplesPerSide;
  depth.assign(size_t(width) * size_t(height), kInfinity);
  color.assign(depth.size(), Rgb{});
}

Camera SampleCamera(const Camera& camera) {
  return camera.Resized(camera.width * kSamplesPerSide, camera.height * kSamplesPerSide);
}

void ForBands(const SurfaceBuffer& buffer, const std::function<void(int, int)>& draw) {
  const int bands = (buffer.height + kBandRows - 1) / kBandRows;
  tbb::parallel_for(0, bands, [&](int band) {
    draw(band * kBandRows, std::min(buffer.height, (band + 1) * kBandRows));
  });
}

void Resolve(const SurfaceBuffer& buffer, const std::array<float, 3>* background, Image8& out) {
  constexpr int kSamples = kSamplesPerSide * kSamplesPerSide;
  out.width = buffer.width / kSamplesPerSide;
  out.height = buffer.height / kSamplesPerSide;
  out.channels = 4;
  out.data.resize(4 * out.pixels());
  tbb::parallel_for(0, out.height, [&](int y) {
    for (int x = 0; x < out.width; ++x) {
      std::array<float, 3> sum{};
      int hits = 0;
      for (int s = 0; s < kSamples; ++s) {
        const size_t i = size_t(y * kSamplesPerSide + s / kSamplesPerSide) * size_t(buffer.width) +
                         size_t(x * kSamplesPerSide + s % kSamplesPerSide);
        if (buffer.depth[i] == kInfinity) continue;
        ++hits;
        for (size_t c = 0; c < 3; ++c) sum[c] += float(buffer.color[i][c]);
      }
      for (size_t c = 0; c < 3; ++c) {
        float value = background
                          ? (sum[c] + 255 * (*background)[c] * float(kSamples - hits)) / kSamples
                          : sum[c] / float(std::max(hits, 1));
        out.at(x, y, int(c)) = uint8_t(std::lround(std::clamp(value, 0.0f, 255.0f)));
      }
      out.at(x, y, 3) = background ? 255 : uint8_t(255 * hits / kSamples);
    }
  });
}

Rgb Lit(const Rgb& rgb, const std::array<float, 3>& normal) {
  const float towards = normal[0] * kLamp[0] + normal[1] * kLamp[1] + normal[2] * kLamp[2];
  const float light = kAmbient + (1 - kAmbient) * std::abs(towards);
  Rgb lit;
  for (size_t c = 0; c < 3; ++c) lit[c] = uint8_t(float(rgb[c]) * light + 0.5f);
  return lit;
}

Rgb ScaleColor(float t) {
  const float place = std::clamp(t, 0.0f, 1.0f) * float(kAnchors.size() - 1);
  const size_t below = std::min(size_t(place), kAnchors.size() - 2);
  const float share = place - float(below);
  Rgb color;
  for (size_t c = 0; c < 3; ++c)
    color[c] =
        uint8_t(std::lround(kAnchors[below][c] * (1 - share) + kAnchors[below + 1][c] * share));
  return color;
}

float CountPlace(int count, int max) {
  if (max <= 1) return count > 0 ? 1.0f : 0.0f;
  const float place = std::log(float(std::max(count, 1))) / std::log(float(max));
  return std::clamp(place, 0.0f, 1.0f);
}

}  // namespace cosplat::viewer
