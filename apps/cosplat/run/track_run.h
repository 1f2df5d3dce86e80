// From a video and its landmarks to a tracked video on disk.
//
// FrameSource, ReadLandmarks -> ChooseFaces -> FitLandmarks -> RefineByAvatars -> a folder in
// IMavatar's layout, which train-avatar and every host's drive read, with track.json and track.html
// about it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/cosplat/run/frame_source.h"
#include "flame/fit/fit_landmarks.h"
#include "splat/base/skipped.h"

namespace cosplat {

constexpr int kAvatarRounds = 3;

struct TrackRunOptions {
  std::string source;     // a video, or a folder of images
  std::string landmarks;  // file of its landmarks
  std::string embedding;  // .npz, for a model without FLAME's topology; or empty
  std::string flame;      // model file
  std::string out;        // folder
  std::string overlay;    // .mp4 or folder, or empty
  double focal = 0;       // px of the whole frame; 0: found
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
  std::vector<std::string> advice;    // AdviceFor, once images are written

  Camera whole_camera() const {
    return marks.crop ? marks.crop->WholeCamera(fit.camera) : fit.camera;
  }
};

// Fits without writing anything. Throws Error naming the file if the landmarks are of another
// video, the model has another topology, or more than a third of the frames are unusable. frames:
// of options.source; they are cropped as the landmarks are.
TrackRun FitTrack(const TrackRunOptions& options, FrameSource& frames);

// Fits and writes <out>/flame_params.json (last), image/, mask/ where there are mattes, track.json
// and track.html; prints a summary. Throws Error as above, before anything is written.
void RunTracking(const TrackRunOptions& options, FrameSource& frames);

// What a track looks like (track_report.cpp): the mesh over the video, and its distance from the
// landmarks.

// The frame, the whole one or its crop, with the fitted mesh shaded over it; landmarks as seen in
// green, as fitted in red.
Image8 DrawOverlay(const TrackRun& run, size_t frame, const Image8& image);

// Writes <out>/track.json (figures per frame), <out>/track.html (the same to look at),
// <out>/skipped_frames.json if there are some, and, if asked for, the overlay of every frame that
// is kept.
void WriteTrackReport(const TrackRunOptions& options,
                      const TrackRun& run,
                      const FrameSource& frames);

// What the person who filmed could do better: what a track shows that its video lacks
// (track_advice.cpp).
//
// A sentence for each of: a head beyond the frame, turns and nods that an avatar will lack, eyes
// that never close, a mouth that never opens or smiles, a short video, a small face, blurred and
// unusable frames, cuts, several people. Empty if nothing is missing. sharpness: [kept]
// SharpnessOf. other_looks: of the kept frames, OtherLooks.
std::vector<std::string> AdviceFor(const TrackRun& run,
                                   const std::vector<double>& sharpness,
                                   const std::vector<size_t>& other_looks);

// The rounds in which small avatars make a track more exact (avatar_rounds.cpp): RefineByAvatar
// (avatar/train/refine_by_avatar.h) with the settings of train-avatar's quick preset, but 800
// steps.
//
// flame: the model's file; image: as RefineByAvatar has it. Frames' eyelids are apart from their
// expressions, before and after. Returns what RefineByAvatar does, and nothing for no rounds.
std::vector<double> RefineByAvatars(const std::string& flame,
                                    TrackedVideo& video,
                                    const std::function<Image8(const TrackedFrame&)>& image,
                                    int rounds,
                                    bool quiet);

// "frames that small avatars had not seen: 24.31 dB, 25.50 dB after round 1, 25.45 dB after round
// 2; kept is round 1".
std::string AvatarRoundsText(const std::vector<double>& psnr);

}  // namespace cosplat
