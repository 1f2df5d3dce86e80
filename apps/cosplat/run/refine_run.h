// From a tracked video to a more exact track of it on disk, by what its images show.
//
// LoadTrackedVideo -> RefineTrack -> RefineByAvatars -> a folder in IMavatar's layout with
// track.json.
#pragma once

#include <string>

#include "apps/cosplat/run/avatar_rounds.h"

namespace cosplat {

struct RefineRunOptions {
  std::string source;  // a tracked video in any layout that has images, of one camera
  std::string flame;   // model file
  std::string out;     // folder
  int avatar_rounds = kAvatarRounds;
  bool quiet = false;
};

// Writes <out>/flame_params.json (last), image/, mask/ where the frames have masks, and track.json;
// prints a summary. Keeps cameras, shape and the split into training and test frames if the test
// frames come last. Throws Error before anything is written if the track cannot be refined.
void RunRefinement(const RefineRunOptions& options);

}  // namespace cosplat
