// Splat files of any supported layout, detected by their first bytes.
#pragma once

#include <string>
#include <vector>

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

// By the first bytes, also of files that gzip packed; .splat has none to tell it by and goes by its
// name, .splat or .splat.gz in any case. kNone if there is nothing at `path`.
SplatLayout SplatLayoutOf(const std::string& path);

// What a file is that is none of the layouts, as far as its first bytes and its name tell: a
// pointer of Git LFS, a web page, another program's format. Empty if they do not.
std::string OtherKindOf(const std::string& path);

// In 3DGS's SH, with OpenCV's axes if those are what the file was made of. What cannot be drawn is
// left out (splat/io/splat_values.h). Positions far from zero are counted from an origin near
// them; one that the file has is kept (docs/files.md). Adds lines to `notes`, if given: what a user
// should know of how the file was read. Throws Error as the layout's reader does, for a file of
// none of these layouts, and for one without splats.
Gaussians ReadSplats(const std::string& path, std::vector<std::string>* notes = nullptr);

// A static scene as a .glb file for other programs.

constexpr int kMaxSplatFileDegree = 3;  // highest that KHR_gaussian_splatting and SOG name

// gaussians: in a world with OpenCV's axes (TurnToGltfAxes), any basis; the file holds
// them rotated to glTF's axes, in 3DGS's SH. Atomic. Throws Error as AddSplats
// (splat/io/splat_primitive.h).
void WriteSceneGlb(const std::string& path,
                   const Gaussians& gaussians,
                   bool truncate_degree = false);

// Drops the bands above `degree`.
void TruncateDegree(int degree, Gaussians& gaussians);

// Conversion from OpenCV's axes to glTF's: a rotation by 180 degrees about x.
//
// Scenes keep the world frame of their data, which for COLMAP and most others follows OpenCV: x
// right, y down, z away from the first camera. glTF has y up and z towards the viewer. The rotation
// (x, y, z) -> (x, -y, -z) maps the former to the latter and keeps right-handedness. FLAME's axes
// (y up, the face towards +z, metres) are already glTF's: an avatar's .glb is not rotated.
//
// Rotates positions, rotations and colours. kPosition must be points in the world. Applied twice,
// it restores the Gaussians (quaternions up to their sign).
void TurnToGltfAxes(Gaussians& gaussians);

}  // namespace cosplat
