// Shared by both layouts of splat PLY files: their properties, the degree, the marks in comments.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "splat/gaussians.h"
#include "splat/io/ply_reader.h"

namespace cosplat {

// A property of the file and its place in Gaussians.
struct PlyColumn {
  std::string name;
  Attribute attribute;
  int component;
};

// All of 3DGS's in file order, except for the normals that follow the position.
std::vector<PlyColumn> SplatColumns(int degree);
// f_rest_*, channel-major, for `coefficients` per channel.
std::vector<PlyColumn> RestColumns(int coefficients);

// From the number of f_rest_* of the current element; throws Error if it matches no degree.
int DegreeOf(const PlyReader& reader);

constexpr std::array<const char*, 3> kPlyOffsets{"offsetx", "offsety", "offsetz"};  // comments

// How Gaussians are to be drawn, as comments. Of those that a file has the last counts:
// "SplatRenderMode: mip" or another mode (Brush, SplatTransform), "antialiased 1" or 0 (Postshot),
// "antialiased" (ours, at first). "low_pass_variance 0.1" is the filter of ours. Without that line
// it is 0.3, as of gsplat, 3DGS and PlayCanvas, or 0.1 for Brush, which says "Exported from Brush".
std::string MarksOf(const Gaussians& gaussians);  // whole lines, or none
void ReadMarks(const PlyReader& reader, Gaussians& gaussians);

// PlayCanvas's compressed layout of splats (SuperSplat, splat-transform), which ReadPly reads.
//
// element chunk, one per 256 vertices: floats min_x .. max_z, min_scale_x .. max_scale_z (log) and,
// in newer files, min_r .. max_b (colours 0.5 + K0 dc; 0..1 if absent).
// element vertex, uints that locate a splat between its chunk's bounds; highest bits first:
//   packed_position, packed_scale   11, 10, 11 bits of x, y, z
//   packed_color                    8 bits each of r, g, b, opacity (which is in 0..1)
//   packed_rotation                 2 bits: which of w, x, y, z is the largest; 10 bits of each of
//                                   the others in this order, -1/sqrt2 .. 1/sqrt2
// element sh, optional: uchar f_rest_*, channel-major, each one of 256 bins of -4 .. 4.

// Whether the header's vertex element has a packed property.
bool IsCompressed(const PlyReader& reader);

// `reader` must not have entered an element yet. Opacities 0 and 1 become finite logits; opacity 0
// is still never rendered. Throws Error naming element, row and property.
Gaussians ReadCompressed(PlyReader& reader);

}  // namespace cosplat
