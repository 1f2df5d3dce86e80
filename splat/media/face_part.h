// Where a face is, and the part of a person's matte that has it.
//
// MatteRefiner (refine_mattes.h) starts from it.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

// px
struct FaceBox {
  double left = HUGE_VAL, top = HUGE_VAL, right = -HUGE_VAL, bottom = -HUGE_VAL;

  double width() const { return right - left; }
  double height() const { return bottom - top; }
  double size() const { return std::sqrt(width() * height()); }  // side of a square of its area
  std::array<double, 2> middle() const { return {(left + right) / 2, (top + bottom) / 2}; }
};

// Clears what of a person's matte is nearer to one of the other faces, in units of their sizes.
void LeaveToOthers(const FaceBox& face, const std::vector<FaceBox>& others, Image8& matte);

constexpr float kClearMatte = 0.04f;  // a network is sure that there is nobody below it

// A matte (1 channel) as [0, 1], of its part with most of the face's pixels, or the largest one if
// there is no face or nothing in its box: with the soft rims of that part, without other parts (but
// for what is within `reach` px of both), without holes in the face.
Image PersonOf(const Image8& matte, const std::optional<FaceBox>& face, int reach);

}  // namespace cosplat
