#include "apps/study/avatar_stability/sketch.h"

#include <algorithm>
#include <cmath>

namespace cosplat {

// Shades every pixel by its distance from the segment, with a one-pixel soft edge.
void Sketch::Line(float x0, float y0, float x1, float y1, const SketchColor& color, float width) {
  const float half = 0.5f * width, dx = x1 - x0, dy = y1 - y0, square = dx * dx + dy * dy;
  const int left = std::max(0, int(std::min(x0, x1) - half - 1));
  const int right = std::min(image_.width - 1, int(std::max(x0, x1) + half + 1));
  const int top = std::max(0, int(std::min(y0, y1) - half - 1));
  const int bottom = std::min(image_.height - 1, int(std::max(y0, y1) + half + 1));
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const float px = float(x) + 0.5f - x0, py = float(y) + 0.5f - y0;
      const float t = square > 0 ? std::clamp((px * dx + py * dy) / square, 0.0f, 1.0f) : 0.0f;
      const float beyond = std::hypot(px - t * dx, py - t * dy) - half;
      const float cover = std::clamp(0.5f - beyond, 0.0f, 1.0f);
      for (int c = 0; c < 3; ++c) {
        uint8_t& value = image_.at(x, y, c);
        value = uint8_t(std::lround(float(value) + cover * (float(color[c]) - float(value))));
      }
    }
}

void Sketch::Dot(float x, float y, float radius, const SketchColor& color) {
  Line(x, y, x, y, color, 2 * radius);
}

}  // namespace cosplat
