// What both layouts of splat PLY files share: the colour bands' properties and the degree.
#pragma once

#include <string>
#include <vector>

#include "splat/gaussians.h"
#include "splat/io/ply_reader.h"

namespace cosplat {

// A property of the file and where it lives in Gaussians.
struct PlyColumn {
  std::string name;
  Attribute attribute;
  int component;
};

// f_rest_*, channel-major, of so many coefficients per channel.
std::vector<PlyColumn> RestColumns(int coefficients);

// From the number of f_rest_* of the element that is being read; Error when no degree has so many.
int DegreeOf(const PlyReader& reader);

// PlayCanvas' compressed layout of splats (SuperSplat, splat-transform), part of ReadPly.
//
// element chunk, one per 256 vertices: floats min_x .. max_z, min_scale_x .. max_scale_z (log) and,
// in newer files, min_r .. max_b (colours 0.5 + K0 dc; 0..1 where they are absent).
// element vertex, uints that say where between its chunk's bounds a splat lies; highest bits first:
//   packed_position, packed_scale   11, 10, 11 bits of x, y, z
//   packed_color                    8 bits each of r, g, b, opacity (which is in 0..1)
//   packed_rotation                 2 bits, which of w, x, y, z is the largest; 10 bits of each of
//                                   the others in this order, -1/sqrt2 .. 1/sqrt2
// element sh, optional: uchar f_rest_*, channel-major, each a 256th of -4 .. 4.

// By the header: whether vertices have a packed property.
bool IsCompressed(const PlyReader& reader);

// `reader` has entered no element yet. Opacities 0 and 1 become finite logits: the first is never
// drawn. Throws Error naming element, row and property.
Gaussians ReadCompressed(PlyReader& reader);

}  // namespace cosplat
