// A voice as the motion of a face: lips by what is heard, blinks and a little sway by chance.
//
// samples at 16 kHz -> VoiceFace::Push -> ScoredFrame, 50 per second -> a live avatar (`cosplat
// voice`), or RecordingOfVoice -> LoadRecording's like (`render --drive audio:FILE`).
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "avatar/live/score_recording.h"
#include "avatar/voice/idle_motion.h"
#include "avatar/voice/mel_features.h"
#include "avatar/voice/viseme_net.h"

namespace cosplat {

class VoiceFace {
 public:
  static constexpr int kFramesPerSecond = 50;
  // Seconds of sound after the moment that a frame shows, before it is there: half a window and
  // what the network looks ahead.
  static constexpr double kDelay =
      (double(kSpeechWindow) / 2 + double(kSpeechHop) * VisemeNet::kLookAhead) / kSoundRate;

  // seed: of blinks and sway; same seed and sound, same face.
  explicit VoiceFace(uint64_t seed);
  // samples: from -1 to 1, one channel at kSoundRate, in any portions. Appends the frames that they
  // complete; timestep k shows the moment k / kFramesPerSecond.
  void Push(std::span<const float> samples, std::vector<ScoredFrame>& frames);
  // What was held back for the look-ahead.
  void Finish(std::vector<ScoredFrame>& frames);

 private:
  // The network by features of one throat's length, and how sure it is of what it hears.
  struct Ear {
    MelFeatures features;
    VisemeNet net;
    std::vector<SpeechFrame> heard;  // of the last Push
    float doubt = 0;                 // entropy of the weights, nats: a running mean over speech
  };

  const VisemeWeights& Listen(size_t frame);
  void Add(const VisemeWeights& weights, float loudness_ahead, std::vector<ScoredFrame>& frames);

  std::vector<Ear> ears_;
  size_t surest_;            // of ears_
  int speech_heard_ = 0;     // frames of speech in the running means
  VisemeWeights weights_{};  // of the surest one
  IdleMotion idle_;
  std::deque<float> loudness_;  // nats, of the frames that the network is behind
  float stress_ = 0;
  int64_t speech_frames_ = 0;
};

// Throws Error(name, ...) if there is no whole frame of sound, or nothing but silence.
ScoreRecording RecordingOfVoice(const std::string& name,
                                std::span<const float> samples,
                                uint64_t seed);

}  // namespace cosplat
