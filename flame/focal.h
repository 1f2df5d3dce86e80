// Another focal length for a tracked video.
#pragma once

#include "flame/model.h"
#include "flame/track.h"

namespace cosplat {

// Whether one camera that stands still shows all frames, so that its focal length may be the
// tracker's assumption. Several are calibrated to each other, and one that moves by its motion.
bool HasOneStillCamera(const TrackedVideo& video);

// Multiplies the camera's focal lengths, and the depth of every head in it, so that each head keeps
// its size in the image and only its perspective changes. The poses stay. Throws Error unless
// HasOneStillCamera.
void ScaleFocal(const FlameModel& flame, double scale, TrackedVideo& video);

}  // namespace cosplat
