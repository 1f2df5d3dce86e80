// The avatar file: a .glb that any splat viewer shows at rest and that this project animates.
//
// avatar/train/avatar_subject.h -> AvatarModel -> WriteAvatarGlb -> file -> ReadAvatarGlb [->
// AttachMesh]
// -> AvatarModel -> avatar/play/player.h. docs/avatar-file.md describes the format field by field.
//
// The file stores the splats at rest in KHR_gaussian_splatting (3DGS's SH up to degree 3) and, in
// the project's own extension COSPLAT_mesh_binding, every trained array bit for bit: the embedding
// on the triangles and the coefficients in their own basis and degree. (Of corrections, if there
// are any, the bases are rounded to 16 bits.)
//
// Coordinates: the canonical mesh is in FLAME's frame: metres, y up, the face towards +z. This is
// glTF's frame, so avatars are written unchanged; only scenes, whose world is OpenCV's, are rotated
// (splat/io/splat_file.h). At rest the surface frame is the identity, so the coefficients of
// both ColorFrames see the same direction and need no rotation either.
//
// Licences: FLAME's data may not be redistributed. Unless the model allows it
// (FlameModel::redistributable) or the caller requests it, the file contains neither the vertices
// nor the faces of the canonical mesh, only FLAME's name and hash, the subject's shape coefficients
// and the static offset, which is the user's own tracking result. AttachMesh then makes the mesh
// from the model file. A model that allows it is in the file as it is, so that the avatar needs no
// other.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "flame/model.h"

namespace cosplat {

struct AvatarFileOptions {
  // Write the mesh, and with a model its expression directions, even if the licence is not known to
  // allow it.
  bool embed_flame = false;
  // With degree 4, omit band 4 from the standard attributes; this project still reads all bands.
  bool truncate_degree = false;
};

// flame: the model that the avatar was trained with. If null, the mesh is written only with
// embed_flame, and without morph targets. The file is written atomically. Throws Error when an
// array of `model` has a wrong size or a non-finite number, the mesh is empty, `flame` is another
// model, or the degree is 4 without truncate_degree.
void WriteAvatarGlb(const std::string& path,
                    const AvatarModel& model,
                    const FlameModel* flame,
                    const AvatarFileOptions& options = {});

// `mesh` is empty when the file contains none: see AttachMesh. Throws Error naming file, field and
// value for anything that is missing, out of range, not finite or of an unknown version.
AvatarModel ReadAvatarGlb(const std::string& path);

// The model that the avatar was trained with, with what was added to it (FlameOf): from the file
// `flame`, or if that is empty from the avatar's own file, avatar_path. Throws Error if neither is
// there, naming the `option` by which the caller's user gives `flame`, and as LoadFlameModel.
FlameModel LoadFlameOf(const AvatarModel& model,
                       const std::string& avatar_path,
                       const std::string& flame,
                       const std::string& option);

// Makes the canonical mesh of an avatar that has none: the subject's shape with the static offset,
// at zero expression and pose or as `canonical_frame` poses it. Throws Error when `flame` has
// another hash than the model that the avatar was trained with (unless `ignore_hash`), or does not
// fit it.
void AttachMesh(AvatarModel& model, const FlameModel& flame, bool ignore_hash = false);

// The avatar at rest as ordinary Gaussians in FLAME's frame; same basis and degree.
Gaussians RestPose(const AvatarModel& model);

// What `cosplat info` prints about a .glb.
struct GlbSummary {
  struct Avatar {
    int version = 0;
    AvatarModel model;
    size_t vertex_count = 0, face_count = 0;  // of the canonical mesh
    size_t expression_count = 0;              // morph targets in the file
  };
  size_t gaussians = 0;
  int degree = 0;  // of the standard attributes, which every reader sees
  std::vector<std::string> extensions_used;
  std::optional<Avatar> avatar;  // not set for a scene
};

// Summarises a file written by WriteAvatarGlb, WriteSceneGlb or another program. Throws Error when
// it has no KHR_gaussian_splatting primitive.
GlbSummary SummarizeGlb(const std::string& path);
// A few lines, each ending with a newline.
std::string ToString(const GlbSummary& summary);

}  // namespace cosplat
