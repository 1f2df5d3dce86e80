// Splats as SPZ files (Niantic), about a ninth of a PLY.
//
// A header of 16 bytes, then per attribute an array over all splats: positions as fixed-point
// numbers of 24 bits, opacities, colours and log scales in a byte each, rotations in 3 or 4 bytes,
// coefficients of bands 1 and up in a byte each. Versions 1 to 3 are one gzip stream; version 4 has
// a plain header of 32 bytes, a table of the arrays' sizes and a Zstandard frame per array. Axes
// are OpenGL's (x right, y up, z back); a world with OpenCV's axes (splat/io/splat_file.h) is
// turned on writing and back on reading. Coefficients are 3DGS's SH.
// Source: github.com/nianticlabs/spz, README of versions 1 to 4.
#pragma once

#include <string>
#include <vector>

#include "splat/gaussians.h"

namespace cosplat {

// Writes versions 2 (the oldest that others read; rotations in 3 bytes), 3 and 4. gaussians: in
// 3DGS's SH, of degree at most 3 (kMaxSplatFileDegree, splat/io/splat_file.h). The fixed point is
// placed so that a step is no longer than 1/16 of the median Gaussian's smallest standard
// deviation, as far as the farthest position allows. seen_bands: of SeenBands
// (splat/io/color_weights.h), by which constant colours make up for coarse bands; or empty. Atomic.
// Throws Error if basis, degree or version is another, if a value is not finite, and if there are
// no or more than 2^32 - 1 Gaussians.
void WriteSpz(const std::string& path,
              const Gaussians& gaussians,
              View<const float> seen_bands,
              int version = 3);

// Versions 1 to 4, degrees 0 to 4; extensions are ignored, which a line in `notes` says, if given.
// In 3DGS's SH. Throws Error naming file and field for another version or degree, for more splats
// than the file can hold, and if an array is damaged, too short or not finite.
Gaussians ReadSpz(const std::string& path, std::vector<std::string>* notes = nullptr);

// Decided by the first bytes, inflated in versions up to 3. False if there is no file.
bool IsSpz(const std::string& path);

}  // namespace cosplat
