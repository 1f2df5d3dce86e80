// Loads what `cosplat play` is given into the viewer's types.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/viewer/session.h"

namespace cosplat {

// model: a run folder, an avatar's .glb, GaussianAvatars' point cloud or a scene's splat file.
// flame: an avatar's FLAME model file; if empty, the one named by the run that contains the avatar.
// Throws Error.
viewer::Content LoadContent(const std::string& model, const std::string& flame);

// Makes a drive (avatar/live/source.h) move the content, which may have gone elsewhere by then; a
// recording can be scrubbed. fps: frame rate of a recording; 0: its own. verbose: of a live drive,
// says on standard error what arrives. The function throws Error.
std::function<void(viewer::Session& session, const std::string& drive)> DriverOf(
    const viewer::Content& content, double fps, bool verbose);

struct PictureSize {
  int width = 0, height = 0;  // px
};

// "WIDTHxHEIGHT" of --size. Throws Error.
PictureSize ParsePictureSize(const std::string& text);

}  // namespace cosplat
