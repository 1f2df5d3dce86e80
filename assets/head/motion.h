// The script of the demonstration video: head motion and camera, per frame.
//
// Speech-like visemes, blinks, glances, brows, head and neck rotation, and a slow camera orbit. The
// last `test_frames` frames combine expressions that the preceding frames never show (winks,
// one-sided smiles, puffed cheeks while speaking, ...), within the same range of poses.
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

// An upright camera at `distance` from the point between head and neck, viewing from `azimuth`
// (towards the subject's left) and `elevation`, radians.
Camera OrbitCamera(float azimuth, float elevation, float distance, int size);

}  // namespace cosplat::procedural
