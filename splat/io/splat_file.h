// Splat files of any supported layout, detected by their first bytes.
#pragma once

#include <string>

#include "splat/gaussians.h"

namespace cosplat {

enum class SplatLayout {
  kNone,     // not a splat file
  kPly,      // 3DGS's or PlayCanvas' compressed (splat/io/ply.h)
  kSpz,      // splat/io/spz.h
  kSog,      // a bundle, meta.json or a folder with one (splat/io/sog.h)
  kRecords,  // .splat (splat/io/splat_records.h)
  kGlb       // glTF, with KHR_gaussian_splatting or not (splat/io/splat_primitive.h)
};

// By the first bytes; .splat has none to tell it by and goes by its name. kNone if there is nothing
// at `path`.
SplatLayout SplatLayoutOf(const std::string& path);

// In 3DGS's SH, with OpenCV's axes if those are what the file was made of. Throws Error as the
// layout's reader does, and for a file of none of these layouts.
Gaussians ReadSplats(const std::string& path);

// A static scene as a .glb file for other programs.

constexpr int kMaxSplatFileDegree = 3;  // highest that KHR_gaussian_splatting and SOG name

// gaussians: in a world with OpenCV's axes (splat/io/splat_primitive.h), any basis; the file holds
// them rotated to glTF's axes, in 3DGS's SH. Atomic. Throws Error as AddSplats
// (splat/io/splat_primitive.h).
void WriteSceneGlb(const std::string& path,
                   const Gaussians& gaussians,
                   bool truncate_degree = false);

// Drops the bands above `degree`.
void TruncateDegree(int degree, Gaussians& gaussians);

}  // namespace cosplat
