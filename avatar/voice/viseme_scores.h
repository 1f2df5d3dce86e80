// What a mouth does for each viseme, as blendshape scores.
#pragma once

#include "avatar/model/blendshape_map.h"
#include "avatar/voice/visemes.h"

namespace cosplat {

// Scores of lips and jaw by ARKit's names, the weighted sums of the visemes' own. Lips that are
// heard to shut (kPP) do shut, whatever else is in the weights. effort: of a usual voice 1; it
// scales how far the jaw opens.
BlendshapeScores ScoresOfVisemes(const VisemeWeights& weights, float effort);

}  // namespace cosplat
