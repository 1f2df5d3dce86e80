// The teeth that VHAP and GaussianAvatars add to FLAME's mesh (Qian 2024), whose avatars have
// Gaussians on them: not those of flame/mouth.h, which this project trains on.
//
// LoadFlameModel -> WithVhapTeeth -> FlamePoser, for avatars read by avatar/io/gaussian_avatars.h.
// Written from the recipe: which vertices of the lips they are made of, and how far from them they
// are, in units of the lips' mean distance.
#pragma once

#include <array>

#include "flame/model.h"

namespace cosplat {

// Number of this geometry in avatar files, where flame/mouth.h has kMouthGeometry.
constexpr int kVhapTeethGeometry = 2;

// Rows of 15 vertices, each from the subject's left to the right: the roots of the upper and of the
// lower teeth, their edges, the backs of both of the upper and of both of the lower teeth.
constexpr int kVhapRow = 15;
constexpr std::array kVhapRowIsUpper = {true, false, true, false, true, true, false, false};
constexpr int kVhapTeeth = kVhapRow * int(kVhapRowIsUpper.size());

// Whether the mesh has as many vertices as FLAME's, whose numbers the recipe names.
bool HasFlameTopology(const FlameModel& model);

// `model` with these 120 vertices and their 168 faces after its own: the upper teeth move with the
// head, the lower teeth with the jaw. Returned unchanged if it has them. Throws Error if it has not
// FLAME's topology, or another mouth.
FlameModel WithVhapTeeth(FlameModel model);

}  // namespace cosplat
