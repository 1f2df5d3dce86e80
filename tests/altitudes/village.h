// A made village: houses around a square, trees, a fence and hills, in metres with z up.
//
// MakeVillage -> DrawVillage, for pictures whose truth is known at every height: patterns of its
// textures fade where they become finer than a pixel of the camera that looks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "assets/head/vec.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"

namespace cosplat {

enum class Material : uint8_t { kGround, kWall, kRoof, kTrunk, kLeaf, kWood };

// What a triangle is painted with.
struct Paint {
  Material material{};
  procedural::Vec origin{};  // of the texture, world
  procedural::Vec right{};   // unit: the texture's first axis; the second is `up`
  procedural::Vec up{};      // unit
  int seed = 0;              // of colour and pattern
};

// What throws shadows, roughly: a box with sides along x and y, or a ball.
struct Blocker {
  procedural::Vec low{}, high{};  // corners of the box; of a ball, of the box around it
  bool ball = false;
};

struct Village {
  std::vector<float> vertices;  // [V, 3]
  std::vector<std::array<int32_t, 3>> faces;
  std::vector<Paint> paints;  // [faces]
  std::vector<Blocker> blockers;
};

// Always the same one.
Village MakeVillage();

// RGBA; the sky is white with alpha 0.
Image8 DrawVillage(const Village& village, const Camera& camera);

// Display-referred RGB, [0, 1], of a point of a face as seen from `eye` by pixels that are
// `pixel_angle` radians wide. barycentrics: of the face's corners, sum 1.
std::array<float, 3> PaintVillage(const Village& village,
                                  int face,
                                  const std::array<float, 3>& barycentrics,
                                  const procedural::Vec& eye,
                                  float pixel_angle);

}  // namespace cosplat
