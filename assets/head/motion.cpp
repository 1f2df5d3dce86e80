#include "assets/head/motion.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "assets/head/procedural_head.h"
#include "assets/head/vec.h"
#include "splat/base/rng.h"

namespace cosplat::procedural {
namespace {

constexpr float kTwoPi = 6.2831853f;
// Of TurnHead's angles, in a frontal video: 10 degrees for 28 + 7 of the root and 7 of the neck.
constexpr float kFrontalShare = 10 / 42.0f;
constexpr float kFocalPerWidth = 2.35f;
constexpr Vec kTarget{0, -0.014f, -0.020f};

// Mouth shape of a speech sound.
struct Viseme {
  float jaw, apart, funnel, pucker, press, smile, chin;
};
constexpr Viseme kVisemes[] = {
    {0.19f, 0.40f, 0.00f, 0.00f, 0, 0.05f, 0},     // a
    {0.10f, 0.65f, 0.00f, 0.00f, 0, 0.35f, 0},     // e
    {0.04f, 0.75f, 0.00f, 0.00f, 0, 0.45f, 0},     // i
    {0.13f, 0.10f, 0.75f, 0.15f, 0, 0.00f, 0},     // o
    {0.05f, 0.00f, 0.35f, 0.80f, 0, 0.00f, 0},     // u
    {0.00f, 0.00f, 0.00f, 0.00f, 0.65f, 0, 0},     // m, b, p
    {0.02f, 0.30f, 0.00f, 0.00f, 0, 0.05f, 0.5f},  // f, v
    {0.05f, 0.45f, 0.00f, 0.00f, 0, 0.15f, 0},     // n, t, s
};
constexpr int kVisemeCount = int(std::size(kVisemes));
constexpr Viseme kPause{0, 0.05f, 0, 0, 0, 0.05f, 0};

// A track of values that eases from key to key.
class EasedTrack {
 public:
  void Add(int frame, float value) { keys_.push_back({frame, value}); }
  float At(int frame) const {
    size_t k = 0;
    while (k + 1 < keys_.size() && keys_[k + 1].frame <= frame) ++k;
    if (k + 1 >= keys_.size()) return keys_.empty() ? 0 : keys_.back().value;
    const float t = float(frame - keys_[k].frame) / float(keys_[k + 1].frame - keys_[k].frame);
    return Mix(keys_[k].value, keys_[k + 1].value, t * t * (3 - 2 * t));
  }

 private:
  struct Key {
    int frame;
    float value;
  };
  std::vector<Key> keys_;
};

class Random {
 public:
  explicit Random(unsigned seed) : rng_{seed} {}
  float Uniform(float low, float high) { return Mix(low, high, rng_.Uniform()); }
  int Integer(int low, int high) {  // both inclusive
    return low + int(rng_.Below(uint64_t(high - low + 1)));
  }

 private:
  Rng rng_;
};

// Syllables of 4 to 8 frames with occasional pauses; every viseme parameter has its own track.
struct Speech {
  EasedTrack jaw, apart, funnel, pucker, press, smile, chin;

  Speech(int frames, Random& random) {
    Add(0, kPause, 1);
    int frame = random.Integer(4, 9), left = random.Integer(5, 10);
    while (frame < frames + 8) {
      if (left-- == 0) {
        Add(frame, kPause, 1);
        frame += random.Integer(8, 16);
        Add(frame, kPause, 1);
        left = random.Integer(5, 11);
      } else {
        Add(frame, kVisemes[random.Integer(0, kVisemeCount - 1)], random.Uniform(0.75f, 1.2f));
      }
      frame += random.Integer(4, 8);
    }
  }

 private:
  void Add(int frame, const Viseme& v, float strength) {
    jaw.Add(frame, v.jaw * strength);
    apart.Add(frame, v.apart * strength);
    funnel.Add(frame, v.funnel * strength);
    pucker.Add(frame, v.pucker * strength);
    press.Add(frame, v.press * strength);
    smile.Add(frame, v.smile * strength);
    chin.Add(frame, v.chin * strength);
  }
};

// Two frames closing, one closed, three opening.
EasedTrack Blinks(int first, int frames, Random& random, int shortest, int longest) {
  EasedTrack track;
  track.Add(0, 0);
  for (int f = first; f < frames; f += random.Integer(shortest, longest)) {
    track.Add(f, 0);
    track.Add(f + 2, 1);
    track.Add(f + 3, 1);
    track.Add(f + 6, 0);
  }
  return track;
}

// Holds a value, then moves to another within `jump` frames: glances and brows.
EasedTrack Holds(
    int frames, Random& random, float low, float high, int shortest, int longest, int jump) {
  EasedTrack track;
  track.Add(0, 0);
  float value = 0;
  for (int f = random.Integer(shortest, longest) / 2; f < frames;) {
    track.Add(f, value);
    value = random.Uniform(low, high);
    track.Add(f + jump, value);
    f += jump + random.Integer(shortest, longest);
  }
  return track;
}

struct Tracks {
  Speech speech;
  EasedTrack blink, gaze_x, gaze_y, brow, inner_brow, mood;
  Tracks(int frames, Random& r)
      : speech(frames, r),
        blink(Blinks(14, frames, r, 34, 62)),
        gaze_x(Holds(frames, r, -0.26f, 0.26f, 16, 34, 3)),
        gaze_y(Holds(frames, r, -0.12f, 0.14f, 20, 40, 3)),
        brow(Holds(frames, r, -0.5f, 1.0f, 12, 30, 7)),
        inner_brow(Holds(frames, r, 0, 0.8f, 20, 45, 9)),
        mood(Holds(frames, r, -0.4f, 0.8f, 24, 50, 12)) {}
};

void Set(FlameParams& p, Expression e, float value) { p.expression[int(e)] += value; }

void Speak(const Tracks& t, int frame, FlameParams& p) {
  p.pose[2][0] = t.speech.jaw.At(frame);
  Set(p, Expression::kLipsApart, t.speech.apart.At(frame));
  Set(p, Expression::kFunnel, t.speech.funnel.At(frame));
  Set(p, Expression::kPucker, t.speech.pucker.At(frame));
  Set(p, Expression::kLipPress, t.speech.press.At(frame));
  Set(p, Expression::kChinRaise, t.speech.chin.At(frame));
  const float mood = t.mood.At(frame);
  const float smile = t.speech.smile.At(frame) + 0.8f * std::max(mood, 0.0f);
  Set(p, Expression::kSmileLeft, smile);
  Set(p, Expression::kSmileRight, smile);
  Set(p, Expression::kSquint, 0.5f * std::max(mood, 0.0f));
  Set(p, Expression::kFrown, std::max(-mood, 0.0f));
}

void MoveFace(const Tracks& t, int frame, FlameParams& p) {
  const float brow = t.brow.At(frame), blink = t.blink.At(frame);
  Set(p, Expression::kBrowUp, std::max(brow, 0.0f));
  Set(p, Expression::kBrowKnit, std::max(-brow, 0.0f) * 1.6f);
  Set(p, Expression::kInnerBrowUp, t.inner_brow.At(frame));
  Set(p, Expression::kBlinkLeft, blink);
  Set(p, Expression::kBlinkRight, blink);
  for (int eye : {3, 4}) {
    p.pose[eye][0] = t.gaze_y.At(frame);
    p.pose[eye][1] = t.gaze_x.At(frame);
  }
}

// Head rotation: sums of slow waves, so that yaw and pitch occur in many combinations.
void TurnHead(float seconds, const std::array<float, 6>& phase, FlameParams& p) {
  auto wave = [&](float period, int k) { return std::sin(kTwoPi * seconds / period + phase[k]); };
  p.pose[0] = {kDegree * (10.5f * wave(3.7f, 0) + 4.5f * wave(1.9f, 1)),
               kDegree * (28 * wave(5.3f, 2) + 7 * wave(2.3f, 3)),
               kDegree * 4.5f * wave(4.3f, 4)};
  p.pose[1] = {
      kDegree * 4 * wave(2.9f, 5), kDegree * 7 * wave(3.1f, 1), kDegree * 2.5f * wave(2.6f, 2)};
}

// Expressions that only the held-out frames show, in addition to speech; s runs from 0 to 1.
void SurpriseExpressions(float s, FlameParams& p) {
  auto during = [&](float from, float to) {
    const float x = (s - from) / (to - from);
    return x <= 0 || x >= 1 ? 0.0f : std::sin(x * kTwoPi / 2) * std::sin(x * kTwoPi / 2);
  };
  Set(p, Expression::kBlinkLeft, 0.95f * during(0.04f, 0.20f));  // a wink
  Set(p, Expression::kSmileLeft, 0.7f * during(0.02f, 0.26f));
  Set(p, Expression::kCheekPuff, 0.55f * during(0.24f, 0.44f));
  Set(p, Expression::kMouthShift, 0.5f * during(0.40f, 0.58f) - 0.4f * during(0.74f, 0.90f));
  Set(p, Expression::kSneer, 0.7f * during(0.50f, 0.70f));
  Set(p, Expression::kWideEyes, 0.8f * during(0.62f, 0.86f));
  Set(p, Expression::kBrowUp, 0.5f * during(0.62f, 0.86f));
  Set(p, Expression::kBlinkRight, 0.95f * during(0.86f, 0.99f));
  for (float& e : p.expression) e = std::min(e, 1.25f);
  for (Expression e : {Expression::kBlinkLeft, Expression::kBlinkRight})
    p.expression[int(e)] = std::min(p.expression[int(e)], 1.0f);
}

}  // namespace

Camera OrbitCamera(float azimuth, float elevation, float distance, int size) {
  const Vec back{std::sin(azimuth) * std::cos(elevation),
                 std::sin(elevation),
                 std::cos(azimuth) * std::cos(elevation)};
  const Vec forward = -back;
  const Vec right = Normalize(Cross(forward, Vec{0, 1, 0}));
  const Vec down = Cross(forward, right);
  const Vec center = kTarget + back * distance;
  Camera camera;
  camera.width = camera.height = size;
  camera.fx = camera.fy = kFocalPerWidth * float(size);
  camera.cx = camera.cy = 0.5f * float(size);
  const Vec rows[3] = {right, down, forward};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) camera.rotation[3 * r + c] = rows[r][c];
    camera.translation[r] = -Dot(rows[r], center);
  }
  return camera;
}

std::vector<ScriptFrame> MakeScript(const ScriptOptions& options) {
  Random random(options.seed);
  const Tracks tracks(options.frames, random);
  std::array<float, 6> phase;
  for (float& p : phase) p = random.Uniform(0, kTwoPi);
  const int train = options.frames - options.test_frames;
  std::vector<ScriptFrame> script(options.frames);
  for (int f = 0; f < options.frames; ++f) {
    ScriptFrame& frame = script[f];
    frame.params.expression.assign(kExpressionCount, 0.0f);
    Speak(tracks, f, frame.params);
    MoveFace(tracks, f, frame.params);
    const float seconds = float(f) / 30;
    TurnHead(seconds, phase, frame.params);
    if (f >= train) SurpriseExpressions((f - train + 0.5f) / options.test_frames, frame.params);
    if (options.frontal) {
      for (const int joint : {0, 1})
        for (float& angle : frame.params.pose[joint]) angle *= kFrontalShare;
      const float azimuth = f < train ? 0 : kTestAzimuths[size_t(f - train) % kTestAzimuths.size()];
      frame.camera = OrbitCamera(azimuth * kDegree, 0, 0.95f, options.size);
      continue;
    }
    frame.camera = OrbitCamera(15 * kDegree * std::sin(kTwoPi * seconds / 7.9f + phase[0]),
                               6 * kDegree * std::sin(kTwoPi * seconds / 6.1f + phase[3]),
                               0.95f + 0.07f * std::sin(kTwoPi * seconds / 9.7f + phase[4]),
                               options.size);
  }
  return script;
}

}  // namespace cosplat::procedural
