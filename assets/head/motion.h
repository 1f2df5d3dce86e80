// The script of the demonstration video: head motion and camera, per frame.
//
// Speech-like visemes, blinks, glances, brows, head and neck rotation, and a slow camera orbit. The
// last `test_frames` frames combine expressions that the preceding frames never show (winks,
// one-sided smiles, puffed cheeks while speaking, ...), within the same range of poses.
#pragma once

#include <array>
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
  // The head turns by no more than 10 degrees before a camera that stands still; in the test frames
  // cameras stand all around it (kTestAzimuths).
  bool frontal = false;
};

// Degrees towards the subject's left, one test frame after another.
constexpr std::array<float, 12> kTestAzimuths{
    -15, 30, -45, 60, -90, 180, 15, -30, 45, -60, 90, 180};

std::vector<ScriptFrame> MakeScript(const ScriptOptions& options);

// An upright camera at `distance` from the point between head and neck, viewing from `azimuth`
// (towards the subject's left) and `elevation`, radians.
Camera OrbitCamera(float azimuth, float elevation, float distance, int size);

}  // namespace cosplat::procedural
