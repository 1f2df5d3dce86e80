// Parts of a FLAME-shaped mesh that differ in what no image shows: where hair grows, and what is
// beyond the mesh's outline. Found from the joints, so that no list of vertices is needed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "flame/model.h"
#include "splat/math/vec.h"

namespace cosplat {

// kFace: the front of the face, beyond which are glasses at most. kScalp: where hair grows. kSides:
// ears, and what long hair falls beside. kBody: from the chin down, with the bust.
enum class HeadPart : uint8_t { kFace, kScalp, kSides, kBody };
constexpr size_t kHeadParts = 4;

struct HeadRegions {
  std::vector<math::Vec3<float>> rest;  // [V] metres, the mesh at rest
  float unit = 0;                       // metres from the eyes to the jaw's joint, about 70 mm
  float eye_height = 0;                 // y, metres
  // [V] in units: how far a vertex is within the scalp; 0 or less elsewhere.
  std::vector<float> within_scalp;
  std::vector<HeadPart> part;  // [V]
  size_t head_vertices = 0;    // those that follow are the bust's

  bool IsBust(size_t v) const { return v >= head_vertices; }
};

// mesh: at rest.
HeadRegions FindHeadRegions(const FlameModel& flame, const CanonicalMesh& mesh);

}  // namespace cosplat
