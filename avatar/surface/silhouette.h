// What an image shows of the posed mesh: the regions that it and its mouth cover, used to detect
// holes in an avatar and to evaluate the mouth separately, and which point of it each pixel shows.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "flame/model.h"
#include "flame/topology.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/math/vec.h"

namespace cosplat {

struct ImagePoint {
  float x, y;   // px
  float depth;  // along the camera's axis, world units; not positive: behind the camera
};
ImagePoint Project(const Camera& camera, const math::Vec3<float>& point);

// [height, width]: 1 at pixels whose centre any triangle covers. Triangles that reach behind the
// camera are ignored. vertices: [V, 3] in the camera's world.
std::vector<uint8_t> MeshSilhouette(const std::vector<float>& vertices,
                                    const std::vector<std::array<int32_t, 3>>& faces,
                                    const Camera& camera);

// What a pixel's centre shows: the point of face `face` with weights (u, v) of its vertices 0
// and 1.
struct MeshPixel {
  int32_t face = -1;  // -1: nothing
  float u = 0, v = 0;
  float depth = 0;  // along the camera's axis, world units
};
// [height, width] the nearest triangles, from either side. Triangles that reach behind the camera
// are ignored. vertices: [V, 3] in the camera's world.
std::vector<MeshPixel> DrawMesh(const std::vector<float>& vertices,
                                const std::vector<std::array<int32_t, 3>>& faces,
                                const Camera& camera);

// Within the image: the box of the uppermost boundary loop of the first
// `head_vertices` vertices (in FLAME the lips; the loops of the neck and of a bust lie below, an
// added mouth's vertices come later), enlarged by half of its size on each side. Empty if there are
// fewer than two loops or the box is outside the image.
Crop MouthBox(const std::vector<float>& vertices,
              const std::vector<float>& canonical_vertices,
              const MeshTopology& topology,
              int head_vertices,
              const Camera& camera);

// The row below the chin, within the image: that of the lowest vertex that follows the jaw. Above
// it images show the head alone, without shoulders and clothes. vertices: [V, 3] in the camera's
// world, FLAME's first.
int ChinRow(const std::vector<float>& vertices, const FlameModel& flame, const Camera& camera);

// Within the image: the box of the mesh above that row, with room for hair, and empty if it is
// outside the image. vertices: as ChinRow has them.
Crop HeadBox(const std::vector<float>& vertices, const FlameModel& flame, const Camera& camera);

}  // namespace cosplat
