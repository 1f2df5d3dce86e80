// Visemes: what of a face phonemes look like; those of Oculus' lip sync (OVR), which OpenXR has
// too.
#pragma once

#include <array>
#include <cstddef>

#include "avatar/model/blendshape_map.h"

namespace cosplat {

enum Viseme {
  kSilent,
  kPP,  // p, b, m: lips shut
  kFF,  // f, v: lower lip to upper teeth
  kTH,  // th
  kDD,  // t, d
  kKK,  // k, g, h, ng
  kCH,  // ch, j, sh
  kSS,  // s, z
  kNN,  // n, l
  kRR,  // r
  kAA,  // a
  kE,   // e, schwa
  kIH,  // i, y
  kOH,  // o
  kOU,  // u, w
  kVisemes
};

// How much of each there is at a moment; the sum is 1. Neighbours in time overlap.
using VisemeWeights = std::array<float, size_t(kVisemes)>;

// Scores of lips and jaw by ARKit's names, the weighted sums of the visemes' own. Lips that are
// heard to shut (kPP) do shut, whatever else is in the weights. effort: of a usual voice 1; it
// scales how far the jaw opens.
BlendshapeScores ScoresOfVisemes(const VisemeWeights& weights, float effort);

}  // namespace cosplat
