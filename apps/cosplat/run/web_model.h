// A model as a browser shows it: the files that apps/web's player opens.
//
// MODEL of a command -> FindWebModel -> `cosplat serve`, `cosplat export --html`.
#pragma once

#include <string>

namespace cosplat {

struct WebModel {
  std::string title;
  // Paths of an avatar's .glb and of its FLAME model, if that is not in the .glb itself, or
  std::string avatar, flame;
  std::string splats;      // of a scene's .ply, .splat, .glb, .spz or .sog
  std::string flame_name;  // the avatar's name of its FLAME model
};

// model: a run's folder, a .glb, a splat file; flame: the FLAME model, or empty for
// the one trained with. Reads everything once, so that what the page cannot open is refused here:
// throws Error as LoadContent, for GaussianAvatars' point clouds, and for SOG that is not one file.
WebModel FindWebModel(const std::string& model, const std::string& flame);

// The folder of the player's npm package: installed beside this program, or of the source tree.
// Throws Error if `file` (such as "dist/player.wasm") was not built.
std::string WebFolder(const std::string& file);

// `cosplat export --html`: the model with its player in one file.
//
// Puts the model into the page that `npm run offline` made (apps/web/dist/offline.html) and writes
// it atomically. A FLAME model that is not in the avatar's file may not be passed on: the page asks
// for it. Throws Error if the page was not built or a file cannot be read or written.
void WriteWebPage(const std::string& path, const WebModel& model);

}  // namespace cosplat
