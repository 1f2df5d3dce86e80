// Avatars trained with GaussianAvatars (Qian et al. 2024).
//
// point_cloud.ply, flame_param.npz, FLAME's model file -> ReadGaussianAvatar -> AvatarModel ->
// avatar/play/player.h, or WriteAvatarGlb. Nothing is converted: the avatar follows the mesh by
// GaussianAvatars' own rule (avatar/math/rigid_embed.h), on its own teeth (flame/vhap_teeth.h).
//
// The PLY has 3DGS's properties and binding_0, the face of each Gaussian; position, rotation and
// scale are in the frame and unit of that face, colours are 3DGS's SH in the world of the track.
// docs/conventions.md says what else it holds.
#pragma once

#include <string>

#include "avatar/model/avatar_model.h"
#include "flame/model.h"

namespace cosplat {

// Whether the PLY file has the property binding_0. Throws Error if its header cannot be read.
bool IsGaussianAvatarPly(const std::string& path);

// The avatar with its mesh, posed by the root's mean rotation and translation: the colours are in
// the world of these. flame: as its file has it; the avatar's is FlameOf(avatar, flame). Shape,
// offsets and the trained range are those of flame_param.npz beside the PLY or, without it, of the
// data set trained on. Throws Error naming file, field and value for what is missing, out of range
// or not finite.
AvatarModel ReadGaussianAvatar(const std::string& path,
                               const FlameModel& flame,
                               const std::string& data = "");

// What `cosplat info` prints about such a file: a few lines, each ending with a newline.
std::string SummarizeGaussianAvatar(const std::string& path);

}  // namespace cosplat
