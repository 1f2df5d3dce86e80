#include "avatar/live/score_recording.h"

#include <algorithm>
#include <filesystem>

#include "flame/io/landmarks.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// Null if none has scores.
const DetectedFace* LargestScored(const LandmarkFrame& frame) {
  const DetectedFace* largest = nullptr;
  for (const DetectedFace& face : frame.faces)
    if (!face.blendshapes.empty() &&
        (!largest || BoxOf(face.points).height() > BoxOf(largest->points).height()))
      largest = &face;
  return largest;
}

}  // namespace

bool IsScoreRecording(const std::string& path) {
  const std::string extension = LowerCase(std::filesystem::path(path).extension().string());
  return extension == ".json" || extension == ".csv";
}

ScoreRecording LoadScores(const std::string& path) {
  if (LowerCase(path).ends_with(".csv")) return LoadLiveLinkRecording(path);
  const LandmarkVideo video = ReadLandmarks(path);
  ScoreRecording recording;
  recording.frames_per_second = video.frames_per_second;
  int first = 0;
  for (const LandmarkFrame& frame : video.frames) {
    const DetectedFace* face = LargestScored(frame);
    if (!face) continue;
    if (recording.frames.empty()) first = frame.frame;
    recording.frames.push_back({int64_t(frame.frame) - first, face->blendshapes, {}});
  }
  if (const size_t without = video.frames.size() - recording.frames.size(); without > 0)
    recording.notes.push_back(Format("{} of {} frames have no face", without, video.frames.size()));
  if (recording.frames.empty())
    throw Error(path, "blendshapes", "no face has any: these landmarks drive no avatar");
  return recording;
}

}  // namespace cosplat
