// Splats of any layout that is read, told by a file's first bytes.
#pragma once

#include <string>

#include "splat/gaussians.h"

namespace cosplat {

// PLY (splat/io/ply.h) or quantised (splat/io/vq_file.h); in 3DGS's SH. Throws Error as these do,
// and for quantised splats whose positions are not points in the world.
Gaussians ReadSplats(const std::string& path);

// A static scene as a .glb file that other programs show.

constexpr int kMaxSplatFileDegree = 3;  // what KHR_gaussian_splatting has names for

// gaussians: in a world with OpenCV's axes (splat/io/splat_primitive.h), any basis; the file holds
// them turned to glTF's axes, in 3DGS's SH. Atomic. Errors as AddSplats
// (splat/io/splat_primitive.h).
void WriteSceneGlb(const std::string& path,
                   const Gaussians& gaussians,
                   bool truncate_degree = false);

}  // namespace cosplat
