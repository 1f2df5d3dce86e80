#include "avatar/voice/visemes.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>

#include "avatar/math/one_euro.h"

namespace cosplat {
namespace {

struct Part {
  const char* name;  // of ARKit, without a side
  bool has_sides;
};
constexpr Part kParts[] = {{"jawOpen", false},
                           {"mouthFunnel", false},
                           {"mouthPucker", false},
                           {"mouthStretch", true},
                           {"mouthSmile", true},
                           {"mouthLowerDown", true},
                           {"mouthUpperUp", true},
                           {"mouthRollLower", false},
                           {"mouthPress", true}};
constexpr size_t kPartCount = std::size(kParts), kJaw = 0;

// By what phonetics say of each: rounded lips for sh, r, o and u, spread ones for s and i, the jaw
// lowest for a, next to closed for s.
// clang-format off
constexpr float kShapes[size_t(kVisemes)][kPartCount] = {
    // jaw, funnel, pucker, stretch, smile, lower down, upper up, roll lower, press
    {},  // sil
    {.00f, .00f, .00f, .00f, .00f, .00f, .00f, .15f, .25f},  // PP
    {.05f, .05f, .00f, .00f, .00f, .00f, .15f, .40f, .00f},  // FF
    {.15f, .00f, .00f, .05f, .00f, .15f, .05f, .00f, .00f},  // TH
    {.13f, .00f, .00f, .05f, .05f, .15f, .05f, .00f, .00f},  // DD
    {.17f, .00f, .00f, .05f, .05f, .12f, .05f, .00f, .00f},  // kk
    {.09f, .50f, .25f, .00f, .00f, .10f, .10f, .00f, .00f},  // CH
    {.05f, .00f, .00f, .20f, .12f, .20f, .05f, .00f, .00f},  // SS
    {.14f, .00f, .00f, .05f, .05f, .12f, .05f, .00f, .00f},  // nn
    {.14f, .25f, .20f, .00f, .00f, .08f, .05f, .00f, .00f},  // RR
    {.50f, .00f, .00f, .08f, .05f, .25f, .10f, .00f, .00f},  // aa
    {.32f, .00f, .00f, .15f, .12f, .20f, .08f, .00f, .00f},  // E
    {.16f, .00f, .00f, .22f, .22f, .18f, .06f, .00f, .00f},  // ih
    {.36f, .40f, .20f, .00f, .00f, .08f, .04f, .00f, .00f},  // oh
    {.16f, .30f, .60f, .00f, .00f, .03f, .02f, .00f, .00f},  // ou
};
// clang-format on

// Weights of kPP at which lips begin to shut, and at which they are shut.
constexpr float kClosing = 0.10f, kClosed = 0.35f;

}  // namespace

BlendshapeScores ScoresOfVisemes(const VisemeWeights& weights, float effort) {
  const float closed = math::Ease((weights[kPP] - kClosing) / (kClosed - kClosing));
  std::array<float, kPartCount> sums{};
  for (size_t viseme = 0; viseme < weights.size(); ++viseme) {
    const float weight =
        viseme == kPP ? std::max(closed, weights[kPP]) : (1 - closed) * weights[viseme];
    for (size_t part = 0; part < kPartCount; ++part) sums[part] += weight * kShapes[viseme][part];
  }
  sums[kJaw] *= effort;
  BlendshapeScores scores;
  for (size_t part = 0; part < kPartCount; ++part) {
    const auto& [name, has_sides] = kParts[part];
    const float score = std::min(sums[part], 1.0f);
    if (!has_sides) scores[name] = score;
    for (const char* side : {"Left", "Right"})
      if (has_sides) scores[std::string(name) + side] = score;
  }
  return scores;
}

}  // namespace cosplat
