#include "avatar/voice/viseme_net.h"

#include <gtest/gtest.h>

#include <numeric>

namespace cosplat {
namespace {

TEST(VisemeNet, WeightsSumToOneWhateverIsHeard) {
  VisemeNet net(OwnVisemeNet());
  for (int i = 0; i < 2000; ++i) {
    MelBands mel;
    for (size_t band = 0; band < kMelBands; ++band)
      mel[band] = i % 100 < 50 ? -8.0f / 3 : float((i * 7 + int(band) * 13) % 29) / 6 - 2.4f;
    const VisemeWeights weights = net.Next(mel);
    EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0f), 1, 1e-4);
    for (const float weight : weights) EXPECT_GE(weight, 0);
  }
}

TEST(VisemeNet, HearsNothingInSilence) {
  VisemeNet net(OwnVisemeNet());
  MelBands quiet;
  quiet.fill(-8.0f / 3);
  VisemeWeights weights{};
  for (int i = 0; i < 100; ++i) weights = net.Next(quiet);
  EXPECT_GT(weights[kSilent], 0.9);
}

}  // namespace
}  // namespace cosplat
