// The script of the demonstration video: what the head does and where the camera is, per frame.
//
// Speech-like visemes, blinks, glances, brows, turning of head and neck, a slow orbit of the
// camera. The last `test_frames` of a script combine expressions that the frames before them never
// show (winks, one-sided smiles, puffed cheeks while speaking, ...), within the same range of
// poses.
#pragma once

#include <vector>

#include "flame/model.h"
#include "splat/base/camera.h"

namespace cosplat::procedural {

struct ScriptFrame {
  FlameParams params;
  Camera camera;
};

struct ScriptOptions {
  int frames = 360;
  int test_frames = 60;
  int size = 512;  // px
  unsigned seed = 0;
};

std::vector<ScriptFrame> MakeScript(const ScriptOptions& options);

// A camera at `distance` from the point between head and neck, seen from `azimuth` (towards the
// subject's left) and `elevation`, radians; upright.
Camera OrbitCamera(float azimuth, float elevation, float distance, int size);

}  // namespace cosplat::procedural
