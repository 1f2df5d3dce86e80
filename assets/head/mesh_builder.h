// Builds a head mesh vertex by vertex and ring by ring, and relaxes it on the sculpted surface.
#pragma once

#include <vector>

#include "assets/head/mesh.h"

namespace cosplat::procedural {

constexpr int kSkinRings = 3;  // around the eyes and the mouth

class MeshBuilder {
 public:
  HeadMesh mesh;

  // `free`: whether Relax may slide the vertex on the sculpted surface.
  int AddVertex(const Vec& position, const VertexLabel& label, bool free);

  // Corners counter-clockwise seen from outside; `flip` mirrors the diagonal.
  void AddQuad(int a, int b, int c, int d, bool flip);
  void AddTriangle(int a, int b, int c) { mesh.faces.push_back({a, b, c}); }

  // Quads between a loop (counter-clockwise from outside) and an inner loop of equal length. The
  // diagonals flip half way round, so that the left and right halves are mirror images.
  void JoinLoops(const std::vector<int>& outer, const std::vector<int>& inner);
  void CloseLoop(const std::vector<int>& loop, int center);

  // Adds rings of free vertices between `outer` and the future loop at `inner_positions`; the last
  // returned ring is not yet joined to anything.
  std::vector<std::vector<int>> AddSkinRings(const std::vector<int>& outer,
                                             const std::vector<Vec>& inner_positions,
                                             int count);

  // Moves every free vertex towards the mean of its neighbours and projects it back onto the solid.
  void Relax(int iterations);

 private:
  std::vector<char> free_;
};

}  // namespace cosplat::procedural
