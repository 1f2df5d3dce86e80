// A static scene as a .glb file that other programs show.
#pragma once

#include <string>

#include "splat/gaussians.h"

namespace cosplat {

constexpr int kMaxSplatFileDegree = 3;  // what KHR_gaussian_splatting has names for

// gaussians: in a world with OpenCV's axes (splat/io/axes.h), any basis; the file holds them turned
// to glTF's axes, in 3DGS's SH. Atomic. Errors as AddSplats (splat/io/splat_primitive.h).
void WriteSceneGlb(const std::string& path,
                   const Gaussians& gaussians,
                   bool truncate_degree = false);

}  // namespace cosplat
