// Which head model a run is about: the user's, or our own head.
#pragma once

#include <string>

#include "avatar/model/avatar_model.h"
#include "flame/model.h"
#include "splat/base/json.h"

namespace cosplat {

// `given`, or where it is empty <folder>/head.npz: our own head (assets/head), which may be passed
// on. It is written unless an earlier run has left it there.
std::string HeadModelFor(const std::string& given, const std::string& folder);
// `given`, or where it is empty the head.npz that HeadModelFor left in the track's folder or beside
// it. Throws Error if there is none.
std::string HeadModelOfTrack(const std::string& given, const std::string& track);

// An avatar with its mesh, and the model that poses it.
struct PosableAvatar {
  AvatarModel model;
  FlameModel flame;
};
// Of a .glb that lies in a run's folder, or (run: null) elsewhere. The model is that `given` by
// --flame, in the avatar's file, or where it was in training. Throws Error as ReadAvatarGlb,
// LoadFlameOf and AttachMesh.
PosableAvatar LoadPosable(const std::string& glb, const JsonField* run, const std::string& given);
// GaussianAvatars' point cloud; flame: the model's file. Throws Error if there is none, and as
// ReadGaussianAvatar.
PosableAvatar LoadGaussianAvatar(const std::string& ply,
                                 const std::string& flame,
                                 const std::string& data = "");

}  // namespace cosplat
