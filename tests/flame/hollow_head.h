// The made head without the inside of its mouth: like FLAME, its mesh ends in the fold behind the
// lips.
#pragma once

#include <algorithm>

#include "assets/head/procedural_head.h"

namespace cosplat::test {

inline FlameModel HollowHead() {
  const ProceduralHead head = MakeProceduralHeadParts();
  FlameModel hollow = head.model;
  std::erase_if(hollow.faces, [&](const std::array<int32_t, 3>& face) {
    return std::any_of(face.begin(), face.end(), [&](int32_t v) {
      return head.mesh.labels[size_t(v)].mouth_ring > procedural::kVestibule;
    });
  });
  return hollow;
}

}  // namespace cosplat::test
