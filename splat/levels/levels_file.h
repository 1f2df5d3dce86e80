// Levels of detail as a file: made once, read as far as it is looked at.
//
// Layout, little-endian: "COSPLOD\n"; uint32 format, degree, basis, antialiased (1: with a
// low-pass filter of 0.1 px^2, 2: of 0.3); uint64 number of Gaussians, from which the blocks follow
// (SceneLevels::LayOut); of each block, as floats, the box's least and most corner and the
// coarseness, and the CRC-32 of its values; the CRC-32 of all that; zeros up to a multiple of 64
// bytes; the values (SceneLevels::values). The world frame is that of the scene.
#pragma once

#include <string>

#include "splat/levels/scene_levels.h"

namespace cosplat {

// By the first bytes; false if there is no such file.
bool IsLevelsFile(const std::string& path);

// Atomic. Throws Error if the file cannot be written or there is nothing to be seen.
void WriteLevels(const std::string& path, const SceneLevels& levels);

// Maps the file into memory: values are read when a block is first used, and its CheckValues finds
// those that are damaged. The file must stay as it is; replacing it by another (WriteLevels does)
// is no change, but shortening it ends the process (SIGBUS), as a disk that fails does. Throws
// Error naming the file and the field.
SceneLevels OpenLevels(const std::string& path);

}  // namespace cosplat
