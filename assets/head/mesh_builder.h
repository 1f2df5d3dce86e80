// Growing a head mesh vertex by vertex and ring by ring, and relaxing it on the sculpted surface.
#pragma once

#include <vector>

#include "assets/head/mesh.h"

namespace cosplat::procedural {

constexpr int kSkinRings = 3;  // around the eyes and the mouth

class MeshBuilder {
 public:
  HeadMesh mesh;

  // `free`: may slide on the sculpted surface in Relax.
  int AddVertex(const Vec& position, const VertexLabel& label, bool free);

  // Corners counter-clockwise seen from outside; the diagonal is mirrored with `flip`.
  void AddQuad(int a, int b, int c, int d, bool flip);
  void AddTriangle(int a, int b, int c) { mesh.faces.push_back({a, b, c}); }

  // Quads between a loop (counter-clockwise from outside) and an equally long one inside it. The
  // diagonals turn over half way round, which keeps left and right halves mirror images.
  void JoinLoops(const std::vector<int>& outer, const std::vector<int>& inner);
  void CloseLoop(const std::vector<int>& loop, int center);

  // Rings of free vertices between `outer` and the loop that `inner_positions` will become; the
  // last ring returned is not joined to anything yet.
  std::vector<std::vector<int>> AddSkinRings(const std::vector<int>& outer,
                                             const std::vector<Vec>& inner_positions,
                                             int count);

  // Moves every free vertex towards the mean of its neighbours and back onto the solid.
  void Relax(int iterations);

 private:
  std::vector<char> free_;
};

}  // namespace cosplat::procedural
