// antimatter15's .splat files: a record of 32 bytes per splat and nothing else.
//
// Little-endian: position and scale (standard deviations, not logarithms) as three floats each;
// red, green, blue and opacity as bytes; the rotation wxyz as bytes, (byte - 128) / 128. There are
// no bands of colour. Axes are those of the PLY that it was made of. Source:
// github.com/antimatter15/splat, convert.py.
#pragma once

#include <string>
#include <vector>

#include "splat/gaussians.h"

namespace cosplat {

// In 3DGS's SH, of degree 0, settled (splat/io/splat_values.h). Throws Error naming record and
// field if the size is not a multiple of 32 bytes, if a number is not finite, and for a negative
// scale.
Gaussians ReadSplatRecords(const std::string& path, std::vector<std::string>* notes = nullptr);

}  // namespace cosplat
