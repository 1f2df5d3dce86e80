// Splats and points as PLY files in 3DGS's layout; PlayCanvas's compressed layout is also read.
//
// Properties, all float: x y z nx ny nz f_dc_0..2 f_rest_* opacity scale_0..2 rot_0..3. f_rest is
// channel-major (all of red, then green, then blue), opacity a logit, scale a logarithm, rotation
// wxyz. Coefficients are always in 3DGS's SH basis: callers convert (splat/basis.h). Comments say
// whether Gaussians::antialiased is set (MarksOf in splat/io/ply_layouts.h); "comment offsetx",
// "offsety" and "offsetz" are Gaussians::origin.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "splat/gaussians.h"

namespace cosplat {

// Binary little-endian, atomic. One without a direction becomes transparent
// (splat/io/splat_values.h). Throws Error if the basis is not kSh, a value is not finite or the
// smoothing is not baked in.
void WritePly(const std::string& path, const Gaussians& gaussians);
// The same of `count` Gaussians that need not be in memory together: those of part(0) to
// part(parts - 1), all of one layout. Throws Error also if these are not as many.
void WritePly(const std::string& path,
              size_t count,
              size_t parts,
              const std::function<Gaussians(size_t)>& part);

// Accepts properties in any order; other properties and elements are ignored. The degree follows
// from the number of f_rest (0, 9, 24, 45, 72). PlayCanvas's layout is detected by its header. Also
// reads 2DGS's (no scale_2), Mip-Splatting's (filter_3D), nerfstudio's with red, green, blue in
// place of f_dc, and files that gzip packed. Settled (splat/io/splat_values.h). Adds lines to
// `notes`, if given: what a user should know of how the file was read. Throws Error naming vertex
// (or chunk) and property for non-finite, missing or truncated values, and for points and
// Scaffold-GS's anchors.
Gaussians ReadPly(const std::string& path, std::vector<std::string>* notes = nullptr);

// Whether the file is in PlayCanvas's compressed layout. Throws Error if the header cannot be read.
bool IsCompressedPly(const std::string& path);

// x y z nx ny nz red green blue, as in 3DGS's input.ply. points: [P, 3]; colors: [P, 3].
void WritePointsPly(const std::string& path,
                    const std::vector<float>& points,
                    const std::vector<uint8_t>& colors,
                    const WorldOrigin& origin = {});

// Positions and, if the file has red, green, blue, colours (0..255); otherwise mid-grey. Returns
// whether positions are stored as doubles. The world's place of points is that of the cameras
// beside them: offsets in the header, which tell where both are, do not count.
bool ReadPointsPly(const std::string& path,
                   std::vector<double>& points,
                   std::vector<uint8_t>& colors);

}  // namespace cosplat
