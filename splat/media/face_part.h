// The part of a person's matte that has the face.
//
// MatteRefiner (refine_mattes.h) starts from it.
#pragma once

#include <optional>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

struct FaceBox {
  double left = 0, top = 0, right = 0, bottom = 0;  // px
};

// Clears what of a person's matte is nearer to one of the other faces, in units of their sizes.
void LeaveToOthers(const FaceBox& face, const std::vector<FaceBox>& others, Image8& matte);

constexpr float kClearMatte = 0.04f;  // a network is sure that there is nobody below it

// A matte (1 channel) as [0, 1], of its part with most of the face's pixels, or the largest one if
// there is no face or nothing in its box: with the soft rims of that part, without other parts (but
// for what is within `reach` px of both), without holes in the face.
Image PersonOf(const Image8& matte, const std::optional<FaceBox>& face, int reach);

}  // namespace cosplat
