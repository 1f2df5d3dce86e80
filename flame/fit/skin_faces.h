// The triangles of FLAME that a camera can compare: head, neck, chest. Private to flame/fit/.
#pragma once

#include <array>
#include <vector>

#include "flame/model.h"

namespace cosplat::internal {

// Without the eyes, which turn on their own, and without an added mouth.
std::vector<std::array<int32_t, 3>> SkinFaces(const FlameModel& model);

}  // namespace cosplat::internal
