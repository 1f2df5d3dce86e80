// From a video and its landmarks to a tracked video on disk.
//
// FrameSource, ReadLandmarks -> ChooseFaces -> FitLandmarks -> RefineByAvatars -> a folder in
// IMavatar's layout, which train-avatar and every host's drive read, with track.json and track.html
// about it.
#pragma once

#include <string>
#include <vector>

#include "apps/cosplat/run/avatar_rounds.h"
#include "apps/cosplat/run/frame_source.h"
#include "flame/fit/fit_landmarks.h"
#include "splat/base/skipped.h"

namespace cosplat {

struct TrackRunOptions {
  std::string source;     // a video, or a folder of images
  std::string landmarks;  // file of its landmarks
  std::string embedding;  // .npz, for a model without FLAME's topology; or empty
  std::string flame;      // model file
  std::string out;        // folder
  std::string overlay;    // .mp4 or folder, or empty
  double focal = 0;       // px; 0: found
  bool silhouette = false;
  int avatar_rounds = kAvatarRounds;
  bool quiet = false;
};

// What was found: the fit, and which of its frames are kept.
struct TrackRun {
  LandmarkVideo marks;
  LandmarkEmbedding embedding;
  FlameModel model;  // with eyelids if it has FLAME's topology
  ChosenFaces chosen;
  LandmarkFit fit;
  std::vector<size_t> kept;           // frames of `fit` that are written, in order
  bool mattes = false;                // whether they have mattes
  std::vector<SkippedFrame> skipped;  // the others, each with the reason
  std::vector<double> held_out_psnr;  // RefineByAvatars'
};

// Fits without writing anything. Throws Error naming the file if the landmarks are of another
// video, the model has another topology, or more than a third of the frames are unusable.
TrackRun FitTrack(const TrackRunOptions& options, const FrameSource& frames);

// Fits and writes <out>/flame_params.json (last), image/, mask/ where there are mattes, track.json
// and track.html; prints a summary. Throws Error as above, before anything is written.
void RunTracking(const TrackRunOptions& options);

}  // namespace cosplat
