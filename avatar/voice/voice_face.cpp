#include "avatar/voice/voice_face.h"

#include <algorithm>
#include <cmath>

#include "avatar/math/one_euro.h"
#include "avatar/voice/viseme_scores.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr int kSpeechFrames = kSpeechRate / VoiceFace::kFramesPerSecond;  // in one of a face
// The loudness of phrases, not of sounds.
constexpr float kStressCutoff = 0.7f;  // Hz
constexpr float kStressNats = 1.5f;    // that count as the most
constexpr float kQuiet = -4;           // nats: below it is no voice
constexpr float kEffort = 0.2f;        // by which the jaw opens more, or less
constexpr float kBrows = 0.25f;        // of browInnerUp

}  // namespace

VoiceFace::VoiceFace(uint64_t seed)
    : features_(MeanOfSpeech(OwnVisemeNet())), net_(OwnVisemeNet()), idle_(seed) {}

void VoiceFace::Push(std::span<const float> samples, std::vector<ScoredFrame>& frames) {
  heard_.clear();
  features_.Push(samples, heard_);
  for (const SpeechFrame& speech : heard_) Add(speech, frames);
}

void VoiceFace::Finish(std::vector<ScoredFrame>& frames) {
  const std::vector<float> silence(kSpeechWindow - kSpeechHop + kSpeechHop * VisemeNet::kLookAhead,
                                   0.0f);
  Push(silence, frames);
}

void VoiceFace::Add(const SpeechFrame& speech, std::vector<ScoredFrame>& frames) {
  const VisemeWeights weights = net_.Next(speech.mel);
  loudness_.push_back(speech.loudness);
  if (loudness_.size() <= size_t(VisemeNet::kLookAhead)) return;
  const float loudness = loudness_.front();
  loudness_.pop_front();
  const float stress = loudness < kQuiet ? 0.0f : std::clamp(loudness / kStressNats, -1.0f, 1.0f);
  stress_ += math::LowPassGain(kStressCutoff, 1.0f / float(kSpeechRate)) * (stress - stress_);
  const int64_t number = speech_frames_++;
  if (number % kSpeechFrames != 0) return;
  ScoredFrame frame;
  frame.timestep = number / kSpeechFrames;
  frame.scores = ScoresOfVisemes(weights, 1 + kEffort * stress_);
  const IdleMotion::Pose idle = idle_.Next(1.0f / float(kFramesPerSecond), stress_);
  frame.head = idle.head;
  frame.scores["eyeBlinkLeft"] = frame.scores["eyeBlinkRight"] = idle.lids;
  frame.scores["browInnerUp"] = kBrows * std::max(0.0f, stress_);
  frames.push_back(std::move(frame));
}

ScoreRecording RecordingOfVoice(const std::string& name,
                                std::span<const float> samples,
                                uint64_t seed) {
  VoiceFace face(seed);
  ScoreRecording recording;
  recording.frames_per_second = VoiceFace::kFramesPerSecond;
  face.Push(samples, recording.frames);
  face.Finish(recording.frames);
  if (samples.size() < kSpeechWindow || recording.frames.empty())
    throw Error(name, "has no sound that lasts a fiftieth of a second");
  return recording;
}

}  // namespace cosplat
