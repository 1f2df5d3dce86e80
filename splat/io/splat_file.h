// Splat files of any supported layout, detected by their first bytes.
#pragma once

#include <string>

#include "splat/gaussians.h"

namespace cosplat {

// PLY (splat/io/ply.h) or quantised (splat/io/vq_file.h); in 3DGS's SH. Throws Error as their
// readers do, and for quantised splats whose positions are not points in the world.
Gaussians ReadSplats(const std::string& path);

// A static scene as a .glb file for other programs.

constexpr int kMaxSplatFileDegree = 3;  // highest that KHR_gaussian_splatting names

// gaussians: in a world with OpenCV's axes (splat/io/splat_primitive.h), any basis; the file holds
// them rotated to glTF's axes, in 3DGS's SH. Atomic. Throws Error as AddSplats
// (splat/io/splat_primitive.h).
void WriteSceneGlb(const std::string& path,
                   const Gaussians& gaussians,
                   bool truncate_degree = false);

}  // namespace cosplat
