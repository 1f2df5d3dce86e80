// Blendshape scores beside the tracked faces of the same frames.
//
// LandmarkVideo, TrackedVideo -> MatchScores -> BlendshapeSamples -> FitBlendshapes.
#pragma once

#include <string>
#include <vector>

#include "flame/io/landmarks.h"
#include "flame/pose.h"
#include "flame/track.h"

namespace cosplat {

struct BlendshapeSamples {
  // [C] of the scores, each of which some frame has; one of the 52 as ARKit writes it
  std::vector<std::string> names;
  // [N] of [C], 0 to 1, in order of time; a score that a frame lacks is 0.
  std::vector<std::vector<float>> scores;
  std::vector<FlameParams> faces;  // [N]
  std::vector<size_t> frames;      // [N], of those that were given

  size_t size() const { return faces.size(); }
};

// The frames that have scores, matched by name. Of several detected faces, that on the tracked head
// counts. poser: of the subject. Throws Error naming the file if it is of another video: no name
// occurs in both, the images have other proportions, or most faces are not where the head is.
BlendshapeSamples MatchScores(const LandmarkVideo& landmarks,
                              const std::vector<TrackedFrame>& frames,
                              const FlamePoser<float>& poser);

}  // namespace cosplat
