// One .npy array as bytes (NumPy format 1.0-3.0): what a member of a .npz holds.
#pragma once

#include <string>
#include <vector>

#include "splat/base/npz.h"

namespace cosplat {

// Parses an array; `file` and `member` name it in errors. Returns false (and leaves `array` alone)
// for arrays of text.
bool ParseNpy(const std::string& file,
              const std::string& member,
              const std::vector<char>& bytes,
              NpyArray& array);

// The bytes of a format 1.0 file in C order: of the array's dtype where that is float16 or 32,
// int32 or uint8 or 16, float32 otherwise.
std::string FormatNpy(const NpyArray& array);

}  // namespace cosplat
