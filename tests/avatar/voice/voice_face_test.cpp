#include "avatar/voice/voice_face.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/expect_error.h"
#include "tests/support/spoken.h"

namespace cosplat {
namespace {

using test::Speak;
using test::Spoken;

std::vector<ScoredFrame> FacesOf(const std::vector<float>& samples) {
  return RecordingOfVoice("a voice", samples, 1).frames;
}

// The mean score from `begin` to `end`, seconds.
float Mean(const std::vector<ScoredFrame>& frames, const char* name, double begin, double end) {
  float sum = 0;
  int count = 0;
  for (const ScoredFrame& frame : frames) {
    const double seconds = double(frame.timestep) / VoiceFace::kFramesPerSecond;
    if (seconds < begin || seconds >= end) continue;
    sum += frame.scores.at(name);
    ++count;
  }
  return sum / float(count);
}

TEST(VoiceFace, VowelsOpenSpreadAndRoundTheLips) {
  const auto frames = FacesOf(Speak({{{}, 0.6},
                                     {test::kSpokenAh, 0.6},
                                     {test::kSpokenEe, 0.6},
                                     {test::kSpokenOo, 0.6},
                                     {{}, 1.2}}));
  EXPECT_LT(Mean(frames, "jawOpen", 0.3, 0.5), 0.1);
  EXPECT_GT(Mean(frames, "jawOpen", 0.8, 1.1), 0.25);
  EXPECT_LT(Mean(frames, "jawOpen", 1.4, 1.7), 0.22);
  EXPECT_GT(Mean(frames, "mouthStretchLeft", 1.4, 1.7), 0.12);
  EXPECT_GT(Mean(frames, "mouthPucker", 2.0, 2.3), 0.25);
  EXPECT_LT(Mean(frames, "mouthPucker", 1.4, 1.7), 0.1);
  EXPECT_LT(Mean(frames, "jawOpen", 3.0, 3.5), 0.1);
}

TEST(VoiceFace, PortionsDoNotMatterAndASeedIsAFace) {
  const std::vector<float> samples = Speak({{test::kSpokenAh, 0.5}, {test::kSpokenOo, 0.5}});
  const std::vector<ScoredFrame> whole = FacesOf(samples);
  EXPECT_EQ(whole.size(), 50u);
  VoiceFace face(1);
  std::vector<ScoredFrame> parts;
  for (size_t i = 0; i < samples.size(); i += 100)
    face.Push(std::span(samples).subspan(i, std::min<size_t>(100, samples.size() - i)), parts);
  // No later than promised.
  EXPECT_GE(double(parts.size()),
            (double(samples.size()) / kSoundRate - VoiceFace::kDelay - 0.01) *
                VoiceFace::kFramesPerSecond);
  face.Finish(parts);
  ASSERT_EQ(parts.size(), whole.size());
  for (size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(parts[i].timestep, int64_t(i));
    EXPECT_EQ(parts[i].scores, whole[i].scores);
    EXPECT_EQ(parts[i].head, whole[i].head);
  }
  EXPECT_NE(RecordingOfVoice("a voice", samples, 2).frames[20].head, whole[20].head);
}

TEST(VoiceFace, WhatIsNoNumberIsSilence) {
  std::vector<float> samples(kSoundRate, std::numeric_limits<float>::quiet_NaN());
  for (size_t i = 0; i < 4000; ++i) samples[4000 + i] = i % 50 < 25 ? 1e20f : -1e20f;
  for (const ScoredFrame& frame : FacesOf(samples))
    for (const auto& [name, score] : frame.scores) {
      EXPECT_GE(score, 0) << name;
      EXPECT_LE(score, 1) << name;
    }
}

TEST(VoiceFace, ASoundTooShortIsRefused) {
  const std::vector<float> samples(100);
  test::ExpectError([&] { RecordingOfVoice("short.wav", samples, 1); },
                    {"short.wav", "no sound that lasts a fiftieth"});
}

// Twenty blinks a minute, give or take, each of some 240 ms; the head sways by few degrees.
TEST(IdleMotion, BlinksAndSways) {
  IdleMotion idle(5);
  int blinks = 0, shut = 0;
  float last = 0, most = 0;
  constexpr int kFrames = 50 * 600;
  for (int i = 0; i < kFrames; ++i) {
    const IdleMotion::Pose pose = idle.Next(0.02f, i % 500 < 250 ? 1.0f : -1.0f);
    EXPECT_GE(pose.lids, 0);
    EXPECT_LE(pose.lids, 1);
    blinks += pose.lids > 0.5f && last <= 0.5f;
    shut += pose.lids > 0.5f;
    last = pose.lids;
    for (const float angle : pose.head) most = std::max(most, std::abs(angle));
  }
  EXPECT_GT(blinks, 10 * 12);
  EXPECT_LT(blinks, 10 * 30);
  EXPECT_NEAR(double(shut) / blinks * 20, 120, 40);  // milliseconds
  EXPECT_GT(most, 0.02);
  EXPECT_LT(most, 0.12);
}

}  // namespace
}  // namespace cosplat
