// Colours for counts, shared by the image and its legend.
#pragma once

#include <array>
#include <cstdint>

namespace cosplat::viewer {

using Rgb = std::array<uint8_t, 3>;

// From dark blue over green to yellow, in even steps of brightness. t: [0, 1], clamped.
Rgb ScaleColor(float t);

// Position of a count on a scale from 0 to `most`, in [0, 1]: logarithmic, since counts per
// triangle span decades.
float CountPlace(int count, int most);

// Triangles without any Gaussian.
constexpr Rgb kNoneColor{70, 70, 74};

}  // namespace cosplat::viewer
