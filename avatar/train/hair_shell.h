// How far hair stands off the mesh, measured where frames show the scalp at the head's outline and
// guessed in between and behind.
#pragma once

#include <vector>

#include "avatar/train/head_regions.h"
#include "avatar/train/mesh_in_frame.h"

namespace cosplat {

// [V] metres along the vertices' normals; 0 outside of the scalp, to whose rim it falls off. At
// most 5 cm on a head of the template's size, of which `scale` is a multiple.
std::vector<float> FindHairShell(const std::vector<MeshInFrame>& frames,
                                 const Faces& faces,
                                 const HeadRegions& regions,
                                 float scale);

}  // namespace cosplat
