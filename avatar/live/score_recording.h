// Recorded blendshape scores: a landmarks file (flame/io/landmarks.h) in which faces have them, or
// a recording of Live Link Face.
//
// FILE.json, FILE.csv -> LoadScores -> LoadRecording, by a BlendshapeMap; or as they are to a live
// avatar
// (`cosplat send`).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "avatar/live/phone_frame.h"
#include "avatar/model/blendshape_map.h"

namespace cosplat {

struct ScoredFrame {
  int64_t timestep = 0;  // counted from the first frame; frames without scores leave a gap
  BlendshapeScores scores;
  HeadAngles head{};  // from rest; of landmarks zero
};

struct ScoreRecording {
  double frames_per_second = 0;     // 0 if unknown
  std::vector<ScoredFrame> frames;  // at least one
  std::vector<std::string> notes;   // what a user should know of how it was read
};

// By its name's ending, .json or .csv: no tracked video is such a file.
bool IsScoreRecording(const std::string& path);

// The largest face of each frame counts. Throws Error as ReadLandmarks or LoadLiveLinkRecording
// does, and if no face has scores.
ScoreRecording LoadScores(const std::string& path);

// Live Link Face's table: a row per frame, with a timecode, 52 scores and the head's angles. Rows
// without scores are left out: the app saw no face. Throws Error naming line, column and value.
ScoreRecording LoadLiveLinkRecording(const std::string& path);
// The same table, beginning at 00:00:00, with timecodes of 60 frames. Scores that it does not have
// are left out. Throws Error if the recording has more frames per second, or the file cannot be
// written.
void WriteLiveLinkRecording(const ScoreRecording& recording, const std::string& path);

}  // namespace cosplat
