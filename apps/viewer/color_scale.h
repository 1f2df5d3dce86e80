// Colours of counts: the same in the image and in its legend.
#pragma once

#include <array>
#include <cstdint>

namespace cosplat::viewer {

using Rgb = std::array<uint8_t, 3>;

// From dark blue over green to yellow, of even steps in brightness. t: [0, 1], clamped.
Rgb ScaleColor(float t);

// Where a count stands on the scale of 0 to `most`: by logarithm, since counts per triangle spread
// over decades. [0, 1].
float CountPlace(int count, int most);

// Triangles without any Gaussian.
constexpr Rgb kNoneColor{70, 70, 74};

}  // namespace cosplat::viewer
