#include "avatar/voice/voice_face.h"

#include <algorithm>
#include <cmath>

#include "avatar/math/one_euro.h"
#include "avatar/voice/visemes.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr int kSpeechFrames = kSpeechRate / VoiceFace::kFramesPerSecond;  // in one of a face
// The loudness of phrases, not of sounds.
constexpr float kStressCutoff = 0.7f;  // Hz
constexpr float kStressNats = 1.5f;    // that count as the most
constexpr float kQuiet = -4;           // nats: below it is no voice
constexpr float kEffort = 0.2f;        // by which the jaw opens more, or less
// Throats: how much higher than usual their resonances are, and how many frames the running means
// of the networks' doubts last. Another one is believed once it is surer by kSurer nats.
constexpr double kWarps[] = {1, 1.08, 1.16};
constexpr int kDoubtFrames = 500;
constexpr float kSpeech = -2, kSurer = 0.02f;  // nats: of loudness; of doubt
constexpr float kBrows = 0.25f;                // of browInnerUp

}  // namespace

VoiceFace::VoiceFace(uint64_t seed) : surest_(0), idle_(seed) {
  const VisemeNetWeights& weights = OwnVisemeNet();
  for (const double warp : kWarps)
    ears_.push_back({MelFeatures(MeanOfSpeech(weights), warp), VisemeNet(weights), {}, 0});
}

// The weights of those of the ears that is surest of late: which throat speaks is not known, and
// the network says most clearly what it hears where resonances are where it learned them.
const VisemeWeights& VoiceFace::Listen(size_t frame) {
  const bool is_speech = ears_[0].heard[frame].loudness > kSpeech;
  if (is_speech) speech_heard_ = std::min(speech_heard_ + 1, kDoubtFrames);
  const size_t before = surest_;
  for (size_t i = 0; i < ears_.size(); ++i) {
    Ear& ear = ears_[i];
    const VisemeWeights weights = ear.net.Next(ear.heard[frame].mel);
    if (i == before) weights_ = weights;
    if (!is_speech) continue;
    float entropy = 0;
    for (const float w : weights) entropy -= w * std::log(w + 1e-9f);
    ear.doubt += (entropy - ear.doubt) / float(speech_heard_);
    if (ear.doubt < ears_[surest_].doubt - kSurer) surest_ = i;
  }
  return weights_;
}

void VoiceFace::Push(std::span<const float> samples, std::vector<ScoredFrame>& frames) {
  for (Ear& ear : ears_) {
    ear.heard.clear();
    ear.features.Push(samples, ear.heard);
  }
  for (size_t i = 0; i < ears_[0].heard.size(); ++i)
    Add(Listen(i), ears_[0].heard[i].loudness, frames);
}

void VoiceFace::Finish(std::vector<ScoredFrame>& frames) {
  const std::vector<float> silence(kSpeechWindow - kSpeechHop + kSpeechHop * VisemeNet::kLookAhead,
                                   0.0f);
  Push(silence, frames);
}

void VoiceFace::Add(const VisemeWeights& weights,
                    float loudness_ahead,
                    std::vector<ScoredFrame>& frames) {
  loudness_.push_back(loudness_ahead);
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
  // A muted track, such as videos have whose sound was removed.
  constexpr float kSilent = 3e-4f;  // -70 dB
  if (std::all_of(samples.begin(), samples.end(), [](float x) { return !(std::abs(x) > kSilent); }))
    throw Error(name, "is silent: nobody is heard in it");
  return recording;
}

}  // namespace cosplat
