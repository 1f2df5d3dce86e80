// Writes the demonstration video of the procedural head, with its exact track, as files.
//
// make-head, tests and benchmarks -> WriteProceduralVideo -> a folder that LoadTrackedVideo reads.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "assets/head/motion.h"
#include "assets/head/procedural_head.h"
#include "flame/fit/landmark_embedding.h"
#include "flame/track.h"
#include "splat/base/image.h"

namespace cosplat {

struct MakeHeadOptions {
  int frames = 360;      // at least 1
  int test_frames = 60;  // the last ones, held out; fewer than frames
  int size = 512;        // px, width and height; 16 to 8192
  bool frontal = false;  // as in ScriptOptions (motion.h)
  unsigned seed = 0;     // of the motion script and of the landmarks' noise
  // px, standard deviation of the noise added to landmarks.json
  double landmark_noise = 0;
};

// Writes IMavatar's layout into `folder` (created if necessary): flame_params.json, image/N.png
// (RGBA), mask/N.png, the model as model.npz, and what a detector would see of it as landmarks.json
// with landmark_embedding.npz. flame_params.json is written last, so that
// an incomplete folder is not mistaken for a video. `progress`, if given, is called after each
// frame with increasing `done`, one call at a time. Throws Error on invalid options or if a file
// cannot be written.
void WriteProceduralVideo(const std::string& folder,
                          const MakeHeadOptions& options,
                          const std::function<void(int done, int total)>& progress = {});

// The landmarks that a detector would see of the made head (landmarks.cpp): known points of its
// surface.

// About as many points as FLAME's embedding has, at the same places: lips, lids, pupils, and spread
// over the front of the face. The landmarks are numbered in this order.
LandmarkEmbedding MadeHeadLandmarks(const ProceduralHead& head);

// Writes <folder>/landmarks.json, with the points as each frame's camera sees them and
// options.landmark_noise added and the masks as mattes, and <folder>/landmark_embedding.npz. Points
// on the far side are written, too. Throws Error if a file cannot be written.
void WriteMadeLandmarks(const std::string& folder,
                        const ProceduralHead& head,
                        const std::vector<TrackedFrame>& frames,
                        const MakeHeadOptions& options);

}  // namespace cosplat
