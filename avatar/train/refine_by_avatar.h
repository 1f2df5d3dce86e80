// Makes a track more exact by avatars of it: analysis by synthesis.
//
// TrackedVideo -> a small avatar, trained on three quarters of the frames -> TrackFitter on all of
// them -> the same video with other parameters; and again. Kept are those by which the quarter that
// was left out is shown best as tracked. An error that differs from frame to frame blurs the avatar
// of all frames, and each frame then differs from it the way its parameters are wrong.
#pragma once

#include <functional>
#include <vector>

#include "avatar/train/avatar_subject.h"
#include "avatar/train/fit_track.h"

namespace cosplat {

struct AvatarRefinement {
  AvatarSettings avatar;                           // iterations: of every training
  std::function<TrainSettings(float unit)> train;  // the same length; unit: AvatarSubject::extent
  FitSettings fit;
  int rounds = 3;
  double face_size = 64;  // px: images are reduced until a face is about that wide
};

// Refines pose, translation and expression of all frames; shape and cameras stay. flame: the model
// that `video` was loaded with, and that avatars are trained on (with a mouth, with eyelids).
// image: RGB, or RGBA with a matte, of the camera's size; called once per frame, in order of time.
// progress, if given, is called with increasing `done`. Returns the mean PSNR, in dB, of the frames
// that were left out, as tracked: at the start, and after each round. The parameters are those of
// the first of the highest: one round's figure differs by tenths from what another avatar of the
// same track would have, so that one that is lower is no reason to stop. Fewer than 20 frames, and
// images without a matte, refine nothing, and nothing is returned. Throws Error if several frames
// show one moment, and as AvatarSubject, Trainer and TrackFitter do. Bit-identical for any number
// of threads.
std::vector<double> RefineByAvatar(const FlameModel& flame,
                                   TrackedVideo& video,
                                   const std::function<Image8(const TrackedFrame&)>& image,
                                   const AvatarRefinement& settings,
                                   const std::function<void(int done, int total)>& progress = {});

}  // namespace cosplat
