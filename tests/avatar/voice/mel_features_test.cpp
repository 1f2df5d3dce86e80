#include "avatar/voice/mel_features.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/spoken.h"

namespace cosplat {
namespace {

MelBands UsualMean() {
  MelBands mean;
  mean.fill(-3);
  return mean;
}

std::vector<SpeechFrame> FramesOf(std::span<const float> samples, size_t portion) {
  MelFeatures features(UsualMean());
  std::vector<SpeechFrame> frames;
  for (size_t i = 0; i < samples.size(); i += portion)
    features.Push(samples.subspan(i, std::min(portion, samples.size() - i)), frames);
  return frames;
}

// A tone that rises from 200 to 4200 Hz in a tenth of a second.
std::vector<float> Chirp() {
  std::vector<float> samples;
  for (int i = 0; i < 1600; ++i) {
    const double t = double(i) / kSoundRate;
    samples.push_back(float(0.3 * std::sin(2 * std::numbers::pi * (200 * t + 20000 * t * t))));
  }
  return samples;
}

// assets/voice/make_voice_net.py's normalise(log_mel(x), -3) of the same samples.
TEST(MelFeatures, AreThoseThatTheNetworkWasTrainedOn) {
  const std::vector<SpeechFrame> frames = FramesOf(Chirp(), 1600);
  ASSERT_EQ(frames.size(), 9u);
  const struct {
    size_t frame;
    std::array<float, 5> bands;  // 0, 5, 13, 26, 39
  } expected[] = {{0, {-0.0603f, 2.0f, 1.031f, -2.6667f, -2.6667f}},
                  {4, {-2.6667f, -2.6667f, -2.6667f, -1.1387f, -2.6667f}},
                  {8, {-2.6667f, -2.6667f, -2.6667f, -1.456f, -2.6667f}}};
  constexpr size_t kBands[] = {0, 5, 13, 26, 39};
  for (const auto& [frame, bands] : expected)
    for (size_t i = 0; i < bands.size(); ++i)
      EXPECT_NEAR(frames[frame].mel[kBands[i]], bands[i], 2e-3) << frame << ", " << kBands[i];
}

TEST(MelFeatures, PortionsDoNotMatter) {
  const std::vector<float> samples = Chirp();
  const std::vector<SpeechFrame> whole = FramesOf(samples, samples.size());
  for (const size_t portion : {1, 7, 160, 333}) {
    const std::vector<SpeechFrame> parts = FramesOf(samples, portion);
    ASSERT_EQ(parts.size(), whole.size());
    for (size_t i = 0; i < parts.size(); ++i) EXPECT_EQ(parts[i].mel, whole[i].mel);
  }
}

TEST(MelFeatures, LevelDoesNotMatterAfterSomeSeconds) {
  std::vector<float> loud;
  for (int round = 0; round < 20; ++round)
    for (const float x :
         test::Speak({{test::kSpokenAh, 0.3}, {{}, 0.1}, {test::kSpokenEe, 0.3}, {{}, 0.1}}))
      loud.push_back(x);
  std::vector<float> quiet = loud;
  for (float& x : quiet) x *= 0.03f;
  const std::vector<SpeechFrame> a = FramesOf(loud, 1600), b = FramesOf(quiet, 1600);
  for (size_t i = a.size() - 35; i < a.size() - 15; ++i)  // a vowel
    EXPECT_NEAR(a[i].loudness, b[i].loudness, 0.4);
}

TEST(MelFeatures, NothingIsEverNotANumber) {
  std::vector<float> samples(4800, std::numeric_limits<float>::quiet_NaN());
  for (size_t i = 1600; i < 3200; ++i)
    samples[i] = i % 2 != 0 ? 1e30f : -std::numeric_limits<float>::infinity();
  for (const SpeechFrame& frame : FramesOf(samples, 160)) {
    EXPECT_TRUE(std::isfinite(frame.loudness));
    for (const float band : frame.mel) EXPECT_TRUE(std::isfinite(band));
  }
}

}  // namespace
}  // namespace cosplat
