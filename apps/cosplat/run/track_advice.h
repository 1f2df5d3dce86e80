// What the person who filmed could do better: what a track shows that its video lacks.
#pragma once

#include <string>
#include <vector>

#include "apps/cosplat/run/track_run.h"

namespace cosplat {

// A sentence for each of: a head beyond the frame, turns and nods that an avatar will lack, eyes
// that never close, a mouth that never opens or smiles, a short video, a small face, blurred and
// unusable frames, cuts, several people. Empty if nothing is missing. sharpness: [kept]
// SharpnessOf. other_looks: of the kept frames, OtherLooks.
std::vector<std::string> AdviceFor(const TrackRun& run,
                                   const std::vector<double>& sharpness,
                                   const std::vector<size_t>& other_looks);

}  // namespace cosplat
