// Which visemes are heard: a recurrent network (Cho et al. 2014, "Learning phrase representations
// using RNN encoder-decoder", GRU) over frames of speech, of 80 kB, made by
// assets/voice/make_voice_net.py.
//
// SpeechFrame -> VisemeNet::Next -> VisemeWeights of kLookAhead frames before.
#pragma once

#include <cstdint>
#include <span>

#include "avatar/voice/mel_features.h"
#include "avatar/voice/visemes.h"

namespace cosplat {

// The weights of a network, shared by those that run it.
struct VisemeNetWeights;

// Of the program's own network. Throws Error if its bytes are damaged.
const VisemeNetWeights& OwnVisemeNet();
// The usual log powers of speech, for MelFeatures.
const MelBands& MeanOfSpeech(const VisemeNetWeights& weights);

class VisemeNet {
 public:
  // Lips show what will be heard, so the network waits for as many frames.
  static constexpr int kLookAhead = 4;

  explicit VisemeNet(const VisemeNetWeights& weights);
  VisemeWeights Next(const MelBands& mel);

 private:
  const VisemeNetWeights& weights_;
  std::vector<float> state_;
};

}  // namespace cosplat
