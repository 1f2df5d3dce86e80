// Where the posed mesh lies in an image: holes in an avatar are looked for inside it, and the mouth
// is measured by itself.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "flame/topology.h"
#include "splat/base/camera.h"

namespace cosplat {

// 1 at pixels whose centre any triangle covers. Triangles that reach behind the camera are left
// out. vertices: [V, 3] in the camera's world.
std::vector<uint8_t> MeshSilhouette(const std::vector<float>& vertices,
                                    const std::vector<std::array<int32_t, 3>>& faces,
                                    const Camera& camera);

// x, y, width, height in px, within the image: the box of the mesh's uppermost boundary loop (the
// lips, in FLAME's make-up; below are the neck's and a bust's) enlarged by half of its size on each
// side. All zero where there are not at least two loops or the box is outside.
std::array<int, 4> MouthBox(const std::vector<float>& vertices,
                            const std::vector<float>& canonical_vertices,
                            const MeshTopology& topology,
                            const Camera& camera);

}  // namespace cosplat
