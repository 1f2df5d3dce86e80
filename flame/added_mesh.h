// Vertices and faces added to a FLAME model after its own.
//
// flame/mouth.h, flame/vhap_teeth.h -> AddToMesh -> a FlameModel as any other.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "flame/model.h"

namespace cosplat {

// A new vertex: a place on the template, the vertices whose shape directions it takes, and how far
// it follows the jaw; for the rest it follows the neck.
struct AddedVertex {
  std::array<float, 3> place{};                     // metres
  std::vector<std::pair<int32_t, float>> shape_of;  // vertices, and weights of their directions
  int32_t moves_with = 0;                           // a vertex
  float motion = 0;  // factor on that vertex's expression and pose directions
  float jaw = 0;
};

// Appends vertices, and faces that index into them. They do not move the joints.
void AddToMesh(const std::vector<AddedVertex>& vertices,
               const std::vector<std::array<int32_t, 3>>& faces,
               FlameModel& model);

}  // namespace cosplat
