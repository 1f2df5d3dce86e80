#include "avatar/live/smoother.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "splat/base/rng.h"

namespace cosplat {
namespace {

constexpr float kTau = 2 * std::numbers::pi_v<float>;
constexpr float kFps = 30;

// Writes x into one channel of a face, reads it back.
struct Channel {
  std::function<float&(FlameParams&)> of;
  float usual;  // a usual motion of it
};
std::vector<Channel> Channels() {
  return {{[](FlameParams& f) -> float& { return f.expression[1]; }, 1},
          {[](FlameParams& f) -> float& { return f.pose[1][1]; }, 0.1f},
          {[](FlameParams& f) -> float& { return f.translation[2]; }, 0.02f}};
}

std::vector<float> Smoothed(const Channel& channel,
                            const math::OneEuro& filter,
                            float fps,
                            const std::vector<float>& samples) {
  FaceSmoother smoother(2);
  std::vector<float> out;
  for (const float x : samples) {
    FlameParams face;
    face.expression.resize(2);
    channel.of(face) = x;
    smoother.Smooth(filter, 1 / fps, face);
    out.push_back(channel.of(face));
  }
  return out;
}

// Milliseconds by which a swing comes later: the difference of phase at its frequency over the last
// eight swings.
float DelayOf(
    const Channel& channel, const math::OneEuro& filter, float fps, float hertz, float amplitude) {
  std::vector<float> in;
  const int per_swing = int(fps / hertz);
  for (int i = 0; i < 16 * per_swing; ++i)
    in.push_back(amplitude * channel.usual * std::sin(kTau * float(i) / float(per_swing)));
  const std::vector<float> out = Smoothed(channel, filter, fps, in);
  float along = 0, across = 0;
  for (size_t i = in.size() / 2; i < in.size(); ++i) {
    along += out[i] * std::sin(kTau * float(i) / float(per_swing));
    across -= out[i] * std::cos(kTau * float(i) / float(per_swing));
  }
  return 1000 * std::atan2(across, along) / (kTau * fps / float(per_swing));
}

// The table of docs/plugin.md, "Smoothing": 30 frames per second; the swing goes one way and the
// other by so many usual motions.
TEST(Smoother, DelaysAsTheDocsSay) {
  struct {
    float amplitude, hertz, milliseconds;
  } const table[] = {{0.1f, 1, 62}, {0.1f, 2, 49}, {1, 1, 33}, {1, 2, 29}, {2, 1, 23}, {2, 2, 21}};
  for (const Channel& channel : Channels())
    for (const auto& row : table)
      EXPECT_NEAR(DelayOf(channel, {}, kFps, row.hertz, row.amplitude), row.milliseconds, 0.5f)
          << row.amplitude << " " << row.hertz;
}

TEST(Smoother, DelaysAlikeAtAnyRate) {
  for (const Channel& channel : Channels())
    EXPECT_NEAR(DelayOf(channel, {}, 30, 1, 1), DelayOf(channel, {}, 120, 1, 1), 2);
}

float Roughness(const std::vector<float>& signal) {
  float sum = 0;
  for (size_t i = signal.size() / 2; i < signal.size(); ++i) sum += signal[i] * signal[i];
  return std::sqrt(sum / float(signal.size() / 2));
}

TEST(Smoother, TakesTheTremblingOut) {
  Rng rng{5};
  for (const Channel& channel : Channels()) {
    std::vector<float> noise(2000);
    for (float& x : noise) x = 0.05f * channel.usual * rng.Normal();
    const float before = Roughness(noise), after = Roughness(Smoothed(channel, {}, kFps, noise));
    // A low pass of gain g leaves sqrt(g / (2 - g)) of white noise: 0.42 at 2 Hz and 30 per second;
    // the noise's own speed opens the filter a little.
    EXPECT_LT(after, 0.5f * before);
    EXPECT_GT(after, 0.3f * before);
  }
}

TEST(Smoother, GoesToWhatStaysAndNoFurther) {
  for (const Channel& channel : Channels()) {
    std::vector<float> step(60, channel.usual);
    step[0] = 0;
    const std::vector<float> out = Smoothed(channel, {}, kFps, step);
    EXPECT_EQ(out[0], 0);
    for (size_t i = 1; i < out.size(); ++i) {
      EXPECT_GE(out[i], out[i - 1]);
      EXPECT_LE(out[i], channel.usual * 1.00001f);
    }
    EXPECT_NEAR(out.back(), channel.usual, 1e-4f * channel.usual);
  }
}

TEST(Smoother, TurnsOnThroughHalfATurn) {
  FaceSmoother smoother(0);
  float last = 0;
  for (int i = 0; i < 200; ++i) {
    FlameParams face;
    const float angle = 0.05f * float(i);  // ten rad in all, at 1.5 rad per second
    face.pose[0] = {0, angle, 0};
    smoother.Smooth({}, 1 / kFps, face);
    const float behind = std::remainder(angle - face.pose[0][1], kTau);
    EXPECT_GE(behind, 0) << i;
    EXPECT_LT(behind, 0.1f) << i;
    EXPECT_LT(behind, last + 0.05f) << i;
    last = behind;
  }
}

TEST(Smoother, WithoutTimeNothingMoves) {
  FaceSmoother smoother(1);
  FlameParams face;
  face.expression = {1};
  smoother.Smooth({}, 0, face);
  EXPECT_EQ(face.expression[0], 1);
  for (const float dt : {0.0f, -1.0f}) {
    face.expression = {2};
    smoother.Smooth({}, dt, face);
    EXPECT_EQ(face.expression[0], 1);
  }
  smoother.Reset();
  face.expression = {2};
  smoother.Smooth({}, 0.1f, face);
  EXPECT_EQ(face.expression[0], 2);
}

}  // namespace
}  // namespace cosplat
