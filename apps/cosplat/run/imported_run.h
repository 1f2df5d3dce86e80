// The run folder of an avatar that was trained elsewhere.
#pragma once

#include <string>

#include "avatar/model/avatar_model.h"

namespace cosplat {

// Files that the avatar was made of.
struct ImportedFiles {
  std::string splats;  // GaussianAvatars' point_cloud.ply
  std::string data;    // data set: a tracked video
  std::string flame;   // FLAME model file
};

// Writes what `render`, `metrics` and `play` read besides avatar.glb: run.json, cameras.json and
// the splats at rest, as of the iteration in the splats' path (iteration_N), else 0. The frames
// held out are those of the data set's own split. Throws Error as LoadDrivingSequence does.
void WriteImportedRun(const std::string& folder,
                      const ImportedFiles& files,
                      const AvatarModel& avatar);

}  // namespace cosplat
