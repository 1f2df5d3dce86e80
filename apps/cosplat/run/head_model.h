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

// The model of an avatar that lies in a run's folder, or (run: null) elsewhere: `given` by --flame,
// in the avatar's file, or where it was in training. Throws Error as LoadFlameOf.
FlameModel LoadFlameOfRun(const AvatarModel& avatar,
                          const std::string& path,
                          const JsonField* run,
                          const std::string& given);

}  // namespace cosplat
