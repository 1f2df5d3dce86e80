// Recorded sequences as live sources: anything that LoadDrivingSequence reads, or blendshape scores
// in a landmarks file or of Live Link Face, at its own pace.
//
// file or folder -> LoadRecording -> OpenRecording (by OpenLiveSource) -> LiveFrame.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "avatar/live/score_recording.h"
#include "avatar/live/source.h"

namespace cosplat {

struct RecordedFrame {
  int64_t timestep = 0;  // counted from the first frame; unusable frames leave a gap
  FlameParams params;
};

struct Recording {
  std::string path;
  double frames_per_second = 0;       // time steps per second
  double unit = 1;                    // metres per unit of the track as stored
  std::vector<RecordedFrame> frames;  // at least one
  std::vector<std::string> notes;     // what a user should know of it, each with its name
};

// Uses the first camera if there are several; scores move expression, jaw and eyes by
// options.blendshapes or, without it, the general map; those of landmarks leave the head at rest.
// Throws Error as LoadDrivingSequence or LoadScores does, when the frame rate is not 0.001 to
// 10000, and when the track needs options.flame and there is none.
Recording LoadRecording(const std::string& path, const LiveSourceOptions& options);

// The same of scores that were loaded or made. name: of what they are from.
Recording RecordingOf(const ScoreRecording& scores,
                      const std::string& name,
                      const LiveSourceOptions& options);

// A face for each time step: gaps repeat the face before.
std::vector<FlameParams> FacesOf(const Recording& recording);

std::unique_ptr<LiveSource> OpenRecording(const std::string& path,
                                          const LiveSourceOptions& options);

}  // namespace cosplat
