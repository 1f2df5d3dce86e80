// Writes the demonstration video of the procedural head, with its exact track, as files.
//
// make-head, tests and benchmarks -> WriteProceduralVideo -> a folder that LoadTrackedVideo reads.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "assets/head/motion.h"
#include "assets/head/procedural_head.h"
#include "splat/base/image.h"

namespace cosplat {

struct MakeHeadOptions {
  int frames = 360;      // at least 1
  int test_frames = 60;  // the last ones, held out; fewer than frames
  int size = 512;        // px, width and height; 16 to 8192
  unsigned seed = 0;     // of the motion script and of the landmarks' noise
  // px, standard deviation of the noise added to landmarks.json
  double landmark_noise = 0;
};

// Writes IMavatar's layout into `folder` (created if necessary): flame_params.json, image/N.png
// (RGBA), mask/N.png, the model as model.npz, and what a detector would see of it as landmarks.json
// with landmark_embedding.npz (assets/head/landmarks.h). flame_params.json is written last, so that
// an incomplete folder is not mistaken for a video. `progress`, if given, is called after each
// frame with increasing `done`, one call at a time. Throws Error on invalid options or if a file
// cannot be written.
void WriteProceduralVideo(const std::string& folder,
                          const MakeHeadOptions& options,
                          const std::function<void(int done, int total)>& progress = {});

}  // namespace cosplat
