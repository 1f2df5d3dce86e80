// What `cosplat play` is given, as the viewer takes it.
#pragma once

#include <string>
#include <vector>

#include "apps/viewer/session.h"

namespace cosplat {

// model: a run's folder, an avatar's .glb, or a scene's splats. flame: the FLAME model file of an
// avatar; where it is empty, the run's that the avatar lies in. Throws Error.
viewer::Content LoadContent(const std::string& model, const std::string& flame);

// "udp://...", "vmc://..." or "stdin:": what comes in as it happens.
bool IsLiveDrive(const std::string& drive);

// Lets a drive (avatar/live/source.h) move the content; a recording can be scrubbed.
// fps: of a recording; 0: its own. Throws Error.
void DriveSession(viewer::Session& session,
                  const viewer::Content& content,
                  const std::string& drive,
                  double fps);

}  // namespace cosplat
