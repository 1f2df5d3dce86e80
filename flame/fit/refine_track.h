// Makes a track that there is more exact, by what its images show.
//
// LoadTrackedVideo -> RefineTrack -> the same video with other parameters. Points of the surface
// keep their brightness from frame to frame (flame/fit/face_texture.h); frames stay near the given
// parameters and near the neighbouring frames. Shape and cameras are left as they are.
#pragma once

#include <functional>
#include <vector>

#include "flame/track.h"

namespace cosplat {

// Refines pose, translation and expression of all frames, with the model that `video` was loaded
// with. image: RGB, or RGBA with a matte, of the camera's size; called once per frame, in order of
// time. progress, if given, is called with increasing `done`. Returns how far points' brightness is
// from their mean, in 8-bit levels: before, and after each round; of points that were not fitted
// to. Throws Error if several cameras show a moment, or if the frames' lenses differ. Bit-identical
// for any number of threads.
std::vector<double> RefineTrack(const FlameModel& model,
                                TrackedVideo& video,
                                const std::function<Image8(const TrackedFrame&)>& image,
                                const std::function<void(int done, int total)>& progress = {});

}  // namespace cosplat
