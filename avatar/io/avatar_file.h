// The avatar file: one .glb that any splat viewer shows at rest and that this project plays.
//
// avatar/train/trainer.h -> AvatarModel -> WriteAvatarGlb -> file -> ReadAvatarGlb [-> AttachMesh]
// -> AvatarModel -> avatar/play/player.h. docs/avatar-file.md describes the format field by field.
//
// The file holds the splats at rest as KHR_gaussian_splatting has them (3DGS's SH up to degree 3),
// and in an extension of our own, COSPLAT_mesh_binding, every trained array bit for bit: the
// embedding on the triangles and the coefficients in their own basis and degree.
//
// Axes: the canonical mesh stands in FLAME's frame, metres, y up, the face towards +z. That is
// glTF's frame, so an avatar is written as it is; only scenes, whose world is OpenCV's, are turned
// (splat/io/splat_primitive.h). At rest the surface frame is the identity, so that the coefficients
// of both ColorFrames see the same direction and need no rotation either.
//
// Licences: FLAME's data is not ours to pass on. Unless the model says that it may be
// (FlameModel::redistributable) or the caller orders it, the file has neither the canonical mesh's
// vertices nor its faces, only FLAME's name and hash, the subject's shape coefficients and, being
// the user's own tracking result, the static offset; AttachMesh makes the mesh from the model file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "flame/model.h"
#include "splat/io/vq_file.h"

namespace cosplat {

struct AvatarFileOptions {
  // Write the mesh, and with a model its expression directions, even if the licence is not known to
  // allow it.
  bool embed_flame = false;
  // With degree 4, leave band 4 out of what other programs read; this project still reads all.
  bool truncate_degree = false;
};

// flame: the model that the avatar was trained with, or null: then the mesh is written only with
// embed_flame, and without morph targets. Atomic. Throws Error when an array of `model` has a wrong
// size or a number that is not finite, the mesh is empty, `flame` is another model, or the degree
// is 4 without truncate_degree.
void WriteAvatarGlb(const std::string& path,
                    const AvatarModel& model,
                    const FlameModel* flame,
                    const AvatarFileOptions& options = {});

// `mesh` is empty when the file has none: see AttachMesh. Throws Error naming file, field and value
// for everything that is missing, out of range, not finite or of another version.
AvatarModel ReadAvatarGlb(const std::string& path);

// Makes the canonical mesh of an avatar that has none: the subject's shape at zero expression and
// pose, with the static offset. Throws Error when `flame` has another hash than the model that the
// avatar was trained with (unless `ignore_hash`), or does not fit it.
void AttachMesh(AvatarModel& model, const FlameModel& flame, bool ignore_hash = false);

// The avatar at rest as ordinary Gaussians in FLAME's frame; same basis and degree.
Gaussians RestPose(const AvatarModel& model);

// What `cosplat info` says of a .glb.
struct GlbSummary {
  struct Avatar {
    int version = 0;
    int degree = 0;  // as trained
    Basis basis = Basis::kDcsh;
    ColorFrame color_frame = ColorFrame::kSurface;
    std::string flame_name, flame_sha256;
    size_t shape_count = 0;
    bool has_static_offset = false;
    bool has_bust = false;
    bool released = false;                    // follows the mesh by ReleasedRule
    size_t vertex_count = 0, face_count = 0;  // of the canonical mesh
    bool has_mesh = false;                    // in the file
    size_t expression_count = 0;              // morph targets in the file
  };
  size_t gaussians = 0;
  int degree = 0;  // of what every reader sees
  std::vector<std::string> extensions_used;
  std::optional<Avatar> avatar;  // nothing for a scene
};

// Of a file by WriteAvatarGlb, WriteSceneGlb or another program. Throws Error when it has no
// KHR_gaussian_splatting primitive.
GlbSummary SummarizeGlb(const std::string& path);
// A few lines, each ended by a newline.
std::string ToString(const GlbSummary& summary);

// An avatar's Gaussians in a file of quantised splats (splat/io/vq_file.h): the least that an
// avatar of a known head takes.
//
// The file is of kind "avatar": its positions are (delta_u, delta_v, d), and it has triangle, int32
// [N], and barycentric, float32 [N, 2], as AvatarModel means them. The mesh and all that is not per
// Gaussian stay in the avatar's .glb.

// `splats`: the quantised Gaussians of an avatar. Makes them of kind "avatar".
void AddEmbedding(const Embedding& embedding, QuantisedSplats& splats);

// Puts the file's Gaussians, in 3DGS's SH, and their embedding in place of the model's, whose mesh
// must be attached. Throws Error as ReadVqFile does, for another kind, and for a triangle that the
// mesh has not.
void ReadQuantisedAvatar(const std::string& path, AvatarModel& model);

}  // namespace cosplat
