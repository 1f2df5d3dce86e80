// Draws lines and dots for the images of a case: a triangle mesh, paths on it, points.
#pragma once

#include <array>

#include "splat/base/image.h"

namespace cosplat {

using SketchColor = std::array<uint8_t, 3>;
constexpr SketchColor kMeshLine{205, 205, 205}, kNaiveInk{200, 40, 40}, kOursInk{30, 90, 190};

class Sketch {
 public:
  // Starts white; coordinates in px from the top left corner.
  Sketch(int width, int height) : image_(width, height, 3, 255) {}
  void Line(float x0, float y0, float x1, float y1, const SketchColor& color, float width = 1);
  void Dot(float x, float y, float radius, const SketchColor& color);
  const Image8& image() const { return image_; }

 private:
  Image8 image_;
};

}  // namespace cosplat
