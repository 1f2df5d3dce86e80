// An avatar's Gaussians in a file of quantised splats (splat/io/vq_file.h): the least that an
// avatar of a known head takes.
//
// The file is of kind "avatar": its positions are (delta_u, delta_v, d), and it has triangle, int32
// [N], and barycentric, float32 [N, 2], as AvatarModel means them. The mesh and all that is not per
// Gaussian stay in the avatar's .glb.
#pragma once

#include <string>

#include "avatar/model/avatar_model.h"
#include "splat/io/vq_file.h"

namespace cosplat {

// `splats`: the quantised Gaussians of an avatar. Makes them of kind "avatar".
void AddEmbedding(const Embedding& embedding, QuantisedSplats& splats);

// Puts the file's Gaussians, in 3DGS's SH, and their embedding in place of the model's, whose mesh
// must be attached. Throws Error as ReadVqFile does, for another kind, and for a triangle that the
// mesh has not.
void ReadQuantisedAvatar(const std::string& path, AvatarModel& model);

}  // namespace cosplat
