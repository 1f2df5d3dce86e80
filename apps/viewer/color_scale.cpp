#include "apps/viewer/color_scale.h"

#include <algorithm>
#include <cmath>

namespace cosplat::viewer {
namespace {

// Chosen by eye for an even increase in lightness.
constexpr std::array<std::array<float, 3>, 6> kAnchors{
    {{52, 24, 106}, {48, 78, 150}, {30, 128, 142}, {58, 176, 112}, {160, 212, 58}, {250, 232, 60}}};

}  // namespace

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

float CountPlace(int count, int most) {
  if (most <= 1) return count > 0 ? 1.0f : 0.0f;
  const float place = std::log(float(std::max(count, 1))) / std::log(float(most));
  return std::clamp(place, 0.0f, 1.0f);
}

}  // namespace cosplat::viewer
