// The procedural head's mesh: a grid around the head with rings of faces around eyes, mouth and
// ears.
//
// Connectivity depends on integers only (never on floating-point comparisons), so that all machines
// produce the same triangles. Positions are projected onto the sculpted solid (sculpt.h) and
// relaxed on it; lids, lips, the inside of the mouth with its teeth, ears and eyeballs are placed
// explicitly. Components: head, left eyeball, right eyeball. The head has two boundary loops: neck
// and throat.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "assets/head/sculpt.h"

namespace cosplat::procedural {

enum class Part : uint8_t { kSkin, kEar, kSocket, kMouth, kLeftEye, kRightEye };

// Rings around the mouth from the skin inwards; the value of VertexLabel::mouth_ring.
enum MouthRing : int {
  kVermilion = 0,  // border of the red of the lips
  kLipMiddle = 1,
  kLipFront = 2,  // where the closed lips begin to touch
  kLipBack = 3,
  kVestibule = 4,  // fold between lip and gum
  kGum = 5,        // upper end of the upper teeth, lower end of the lower
  kToothEdge = 6,
  kToothBack = 7,
  kPalate = 8,  // or the tongue
  kThroat = 9,  // boundary loop
};
constexpr int kNoRing = -99;
constexpr int kEarRings = 8;

struct VertexLabel {
  Part part = Part::kSkin;
  int mouth_ring = kNoRing;  // -3..-1: the rings of skin outside the lips
  int lid_ring = kNoRing;    // skin: 3, 2, 1; lid: outer edge 0, inner edge -1; behind it: < -1
  float along = 0;         // mouth: -1 (right corner) .. 1 (left); eye: -1 (medial) .. 1 (lateral)
  float upper = 0;         // mouth and lids: 1 upper, -1 lower, 0 at the corners
  int ear_ring = kNoRing;  // 0 at the skull .. kEarRings in the middle of the concha
};

struct HeadMesh {
  std::vector<Vec> positions;
  std::vector<VertexLabel> labels;
  std::vector<std::array<int32_t, 3>> faces;  // counter-clockwise outside
  std::vector<int> neck_loop, throat_loop;
  std::array<std::vector<int>, 2> lid_loops;  // outer edge of the lids: left eye, right eye
  std::vector<int> lip_loop;                  // kLipFront
};

HeadMesh MakeHeadMesh();

// Area-weighted vertex normals, unit length.
std::vector<Vec> VertexNormals(const std::vector<Vec>& positions,
                               const std::vector<std::array<int32_t, 3>>& faces);

// Parts of MakeHeadMesh, each in its own file.
class MeshBuilder;
// `loop`: a closed loop of the grid, counter-clockwise seen from outside, starting at the middle of
// its -x side (eyes, mouth) and going down.
void AddEye(MeshBuilder& builder, const std::vector<int>& loop, bool left);
void AddMouth(MeshBuilder& builder, const std::vector<int>& loop);
void AddEar(MeshBuilder& builder, const std::vector<int>& loop, bool left);
void AddEyeball(MeshBuilder& builder, bool left);

}  // namespace cosplat::procedural
