// What the person who filmed could do better: what a track shows that its video lacks.
#pragma once

#include <string>
#include <vector>

#include "apps/cosplat/run/track_run.h"

namespace cosplat {

// A sentence for each of: turns and nods that an avatar will lack, eyes that never close, a mouth
// that never opens or smiles, a short video, a small face, blurred and unusable frames, cuts. Empty
// if nothing is missing. sharpness: [kept] SharpnessOf.
std::vector<std::string> AdviceFor(const TrackRun& run, const std::vector<double>& sharpness);

}  // namespace cosplat
