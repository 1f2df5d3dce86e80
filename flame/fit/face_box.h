// Where a face's landmarks are.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "flame/io/landmarks.h"

namespace cosplat {

// The extent of points, px.
struct LandmarkBox {
  double left = HUGE_VAL, top = HUGE_VAL, right = -HUGE_VAL, bottom = -HUGE_VAL;

  double width() const { return right - left; }
  double height() const { return bottom - top; }
  double size() const { return std::sqrt(width() * height()); }  // side of a square of its area
  std::array<double, 2> middle() const { return {(left + right) / 2, (top + bottom) / 2}; }
};

inline LandmarkBox BoxOf(const std::vector<std::array<double, 2>>& points) {
  LandmarkBox box;
  for (const auto& [x, y] : points) {
    box.left = std::min(box.left, x), box.right = std::max(box.right, x);
    box.top = std::min(box.top, y), box.bottom = std::max(box.bottom, y);
  }
  return box;
}

}  // namespace cosplat
