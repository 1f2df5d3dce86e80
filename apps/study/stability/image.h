// Small images of the results of stability cases.
#pragma once

#include <algorithm>
#include <cmath>

#include "splat/base/image.h"
#include "splat/math/vec.h"

namespace cosplat {

// Non-finite colours are painted magenta to make them visible.
inline void SetPixel(Image8& image, int x, int y, const math::Vec3<float>& color) {
  const float channels[3] = {color.x, color.y, color.z};
  const bool is_number = std::isfinite(color.x) && std::isfinite(color.y) && std::isfinite(color.z);
  constexpr uint8_t kNotANumber[3] = {255, 0, 255};
  for (int c = 0; c < 3; ++c)
    image.at(x, y, c) =
        is_number ? uint8_t(255 * std::clamp(channels[c], 0.0f, 1.0f) + 0.5f) : kNotANumber[c];
}

// Evaluates color(x, y) at every pixel.
template <class F>
Image8 Paint(int width, int height, const F& color) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) SetPixel(image, x, y, color(x, y));
  return image;
}

inline Image8 ImageOf(const Image& image) {
  return Paint(image.width, image.height, [&](int x, int y) {
    return math::Vec3<float>{image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
  });
}

}  // namespace cosplat
