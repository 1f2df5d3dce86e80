// Splats of any layout that is read, told by a file's first bytes.
#pragma once

#include <string>

#include "splat/gaussians.h"

namespace cosplat {

// PLY (splat/io/ply.h) or quantised (splat/io/vq_file.h); in 3DGS's SH. Throws Error as these do,
// and for quantised splats whose positions are not points in the world.
Gaussians ReadSplats(const std::string& path);

}  // namespace cosplat
