#include "avatar/live/recording.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "avatar/live/packet_input.h"
#include "avatar/model/avatar_mesh.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/base/skipped.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// For tracks that do not store it: the frame rate of most published ones.
constexpr double kDefaultFramesPerSecond = 25;

// own: the recording's, 0 if unknown.
double FrameRate(const std::string& path, double own, const LiveSourceOptions& options) {
  double rate = options.frames_per_second;
  if (rate == 0) rate = own;
  if (rate == 0) rate = kDefaultFramesPerSecond;
  if (!(rate >= 0.001 && rate <= 10'000))
    throw Error(path, "frames per second", Format("{:g}, expected 0.001 to 10000", rate));
  return rate;
}

// What a user should know of how a track drives.
std::vector<std::string> NotesOf(const TrackedVideo& video,
                                 const std::vector<const FlameParams*>& faces,
                                 const FlameModel* flame) {
  constexpr float kMost = 50;  // standard deviations; exaggeration has less
  std::vector<std::string> notes;
  if (flame != nullptr)
    if (const std::string unused = UnusedExpressions(*flame, faces); !unused.empty())
      notes.push_back(unused);
  std::vector<Finding> skipped;
  NoteSkipped(video.train.size() + video.test.size(), video.skipped, "frames", skipped);
  for (const Finding& finding : skipped) notes.push_back(finding.text);
  constexpr float kMostTurned = 3.2f;  // radians, of a joint about another
  float most = 0, turned = 0;
  for (const FlameParams* face : faces) {
    for (const float e : face->expression) most = std::max(most, std::abs(e));
    for (size_t j = 1; j < face->pose.size(); ++j)
      for (const float angle : face->pose[j]) turned = std::max(turned, std::abs(angle));
  }
  if (turned > kMostTurned)
    notes.push_back(
        Format("turns neck, jaw or eyes by {:.3g} radians: are these degrees?", turned));
  if (most > kMost)
    notes.push_back(Format("has expressions of up to {:g} standard deviations", most));
  for (std::string& note : notes) note.insert(0, video.source + ": ");
  notes.insert(notes.begin(), video.notes.begin(), video.notes.end());
  return notes;
}

class RecordedSource : public LiveSource {
 public:
  RecordedSource(Recording recording, bool loop) : recording_(std::move(recording)), loop_(loop) {}

  bool Poll(int64_t now_ns, LiveFrame& out) override {
    if (!started_) start_ns_ = now_ns;
    started_ = true;
    const uint64_t elapsed = now_ns > start_ns_ ? uint64_t(now_ns) - uint64_t(start_ns_) : 0;
    const uint64_t step = StepAt(elapsed);
    const uint64_t rounds = loop_ ? step / Length() : 0;
    const uint64_t number = rounds * recording_.frames.size() + FrameAt(step - rounds * Length());
    if (number < next_) return false;
    const RecordedFrame& frame = recording_.frames[number % recording_.frames.size()];
    counts_.replaced += number - next_;
    ++counts_.frames;
    next_ = number + 1;
    const double began = double(rounds * Length() + uint64_t(frame.timestep)) * StepNs();
    out.params = frame.params;
    out.sequence = number;
    out.time_ns = now_ns - int64_t(std::max(0.0, double(elapsed) - began));
    return true;
  }

  bool Ended() const override { return !loop_ && next_ == recording_.frames.size(); }
  LiveCounts Counts() const override { return counts_; }
  std::string Description() const override {
    return "recorded sequence " + std::filesystem::path(recording_.path).filename().string() +
           ", " + std::to_string(recording_.frames.size()) + " frames at " +
           Format("{:g} per second", recording_.frames_per_second);
  }

 private:
  uint64_t Length() const { return uint64_t(recording_.frames.back().timestep) + 1; }
  double StepNs() const { return 1e9 / recording_.frames_per_second; }

  // A host that counts time in whole frames rounds it to nanoseconds. Time steps begin a thousandth
  // of a step early, so that such a host gets every frame once.
  uint64_t StepAt(uint64_t elapsed_ns) const {
    return uint64_t(double(elapsed_ns) / StepNs() + 1e-3);
  }

  // The last frame that has begun at `step`.
  uint64_t FrameAt(uint64_t step) const {
    const auto after = std::upper_bound(
        recording_.frames.begin(),
        recording_.frames.end(),
        step,
        [](uint64_t s, const RecordedFrame& frame) { return s < uint64_t(frame.timestep); });
    return uint64_t(after - recording_.frames.begin()) - 1;
  }

  Recording recording_;
  bool loop_;
  bool started_ = false;
  int64_t start_ns_ = 0;
  uint64_t next_ = 0;  // number of the next frame; keeps counting through loops
  LiveCounts counts_;
};

}  // namespace

Recording RecordingOf(const ScoreRecording& scores,
                      const std::string& name,
                      const LiveSourceOptions& options) {
  const BlendshapeMap map = ChooseBlendshapeMap("", options).map;
  Recording recording;
  recording.path = name;
  recording.frames_per_second = FrameRate(name, scores.frames_per_second, options);
  for (const ScoredFrame& frame : scores.frames) {
    recording.frames.push_back({frame.timestep, {}});
    FlameParams& params = recording.frames.back().params;
    params.pose[0] = TurnOf(frame.head);
    ApplyBlendshapes(map, frame.scores, params);
    PutOnRest(options.rest, params);
  }
  for (const std::string& note : scores.notes) recording.notes.push_back(name + ": " + note);
  const auto differs = [](const auto& frames, const auto& of) {
    return std::any_of(
        frames.begin(), frames.end(), [&](const auto& f) { return of(f) != of(frames[0]); });
  };
  if (differs(
          scores.frames, [](const ScoredFrame& f) -> const auto& { return f.scores; }) &&
      !differs(
          recording.frames,
          [](const RecordedFrame& f) -> const auto& { return f.params.expression; }) &&
      !differs(
          recording.frames, [](const RecordedFrame& f) -> const auto& { return f.params.pose; }))
    throw Error(name, "none of its scores moves the avatar: are they named as ARKit's?");
  return recording;
}

std::vector<FlameParams> FacesOf(const Recording& recording) {
  std::vector<FlameParams> faces;
  for (const RecordedFrame& frame : recording.frames) {
    while (int64_t(faces.size()) < frame.timestep) faces.push_back(faces.back());
    faces.push_back(frame.params);
  }
  return faces;
}

Recording LoadRecording(const std::string& path, const LiveSourceOptions& options) {
  if (IsScoreRecording(path)) return RecordingOf(LoadScores(path), path, options);
  const TrackedVideo video = LoadDrivingSequence(path, options.flame);
  if (video.head_is_fixed)
    throw Error(path, "the FLAME model is needed: in this track the camera moves, not the head");
  const std::vector<const TrackedFrame*> instants = InstantsOf(video);
  Recording recording;
  recording.path = path;
  recording.unit = video.unit;
  recording.frames_per_second = FrameRate(video.source, video.frames_per_second, options);
  std::vector<FlameParams> params;
  std::vector<const FlameParams*> faces;
  for (const TrackedFrame* frame : instants) {
    params.push_back(frame->params);
    faces.push_back(&frame->params);
  }
  recording.notes = NotesOf(video, faces, options.flame);
  params = Retarget(std::move(params), options.rest);
  for (size_t i = 0; i < instants.size(); ++i)
    recording.frames.push_back({int64_t(instants[i]->timestep) - instants[0]->timestep, params[i]});
  return recording;
}

std::unique_ptr<LiveSource> OpenRecording(const std::string& path,
                                          const LiveSourceOptions& options) {
  return std::make_unique<RecordedSource>(LoadRecording(path, options), options.loop);
}

}  // namespace cosplat
