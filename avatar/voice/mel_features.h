// Sound as the network hears it: log powers of 40 bands of a mel scale, less their running mean
// over speech, which is what voice, microphone and room have in common at all times.
//
// samples -> MelFeatures::Push -> SpeechFrame, 100 per second -> VisemeNet.
// assets/voice/make_voice_net.py computes the same to train by; tests compare the two.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace cosplat {

constexpr int kSoundRate = 16000;                          // samples per second
constexpr size_t kSpeechHop = 160, kSpeechWindow = 320;    // samples between frames, and of each
constexpr int kSpeechRate = kSoundRate / int(kSpeechHop);  // frames per second
constexpr size_t kMelBands = 40;
using MelBands = std::array<float, kMelBands>;

struct SpeechFrame {
  MelBands mel{};
  float loudness = 0;  // nats of power above the speaker's mean
};

class MelFeatures {
 public:
  // mean: log powers of speech, before any has been heard. warp: of the bands' frequencies; above 1
  // a shorter throat sounds like the usual one (Lee & Rose 1996).
  explicit MelFeatures(const MelBands& mean, double warp = 1);
  ~MelFeatures();
  MelFeatures(MelFeatures&& other) noexcept;
  // samples: from -1 to 1, in any portions; NaN and what is beyond count as silence and as -1 or 1.
  // Appends the frames that they complete.
  void Push(std::span<const float> samples, std::vector<SpeechFrame>& frames);

 private:
  struct Spectrum;
  SpeechFrame Normalised(const MelBands& log_power);

  std::unique_ptr<Spectrum> spectrum_;
  std::vector<float> pending_;  // samples
  MelBands mean_;
  int frames_in_mean_;
  float peak_;  // of the bands' mean log power, slowly forgotten
};

}  // namespace cosplat
