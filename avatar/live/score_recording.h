// Recorded blendshape scores: a landmarks file (flame/io/landmarks.h) in which faces have them.
//
// FILE.json -> LoadScores -> LoadRecording, by a BlendshapeMap; or as they are to a live avatar
// (`cosplat send`).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "avatar/model/blendshape_map.h"

namespace cosplat {

struct ScoredFrame {
  int64_t timestep = 0;  // counted from the first frame; frames without scores leave a gap
  BlendshapeScores scores;
};

struct ScoreRecording {
  double frames_per_second = 0;     // 0 if unknown
  std::vector<ScoredFrame> frames;  // at least one
};

// By its name's ending, .json: no tracked video is such a file.
bool IsScoreRecording(const std::string& path);

// The largest face of each frame counts. Throws Error as ReadLandmarks does, and if no face has
// scores.
ScoreRecording LoadScores(const std::string& path);

}  // namespace cosplat
