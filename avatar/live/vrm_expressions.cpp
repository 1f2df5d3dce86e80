#include "avatar/live/vrm_expressions.h"

#include <algorithm>
#include <array>

namespace cosplat {
namespace {

// A score by its name in ARKit; "eyeBlink*" stands for both sides.
struct Score {
  std::string_view name;
  float score = 0;
};

struct Expression {
  std::string_view vrm1, vrm0;
  std::array<Score, 4> scores;
};

// Mouths by what the lips do for the vowel, moods by what their faces have in common; half of what
// a person can do at most, so that a vowel fits on top of a mood.
constexpr Expression kExpressions[] = {
    {"aa", "A", {{{"jawOpen", 0.6f}, {"mouthLowerDown*", 0.2f}}}},
    {"ih", "I", {{{"jawOpen", 0.15f}, {"mouthStretch*", 0.4f}, {"mouthSmile*", 0.2f}}}},
    {"ou", "U", {{{"jawOpen", 0.15f}, {"mouthPucker", 0.6f}, {"mouthFunnel", 0.3f}}}},
    {"ee", "E", {{{"jawOpen", 0.3f}, {"mouthStretch*", 0.3f}, {"mouthSmile*", 0.2f}}}},
    {"oh", "O", {{{"jawOpen", 0.4f}, {"mouthFunnel", 0.6f}, {"mouthPucker", 0.2f}}}},
    {"blink", "Blink", {{{"eyeBlink*", 1}}}},
    {"blinkLeft", "Blink_L", {{{"eyeBlinkLeft", 1}}}},
    {"blinkRight", "Blink_R", {{{"eyeBlinkRight", 1}}}},
    {"happy", "Joy", {{{"mouthSmile*", 0.8f}, {"cheekSquint*", 0.5f}, {"eyeSquint*", 0.3f}}}},
    {"angry", "Angry", {{{"browDown*", 0.8f}, {"noseSneer*", 0.4f}, {"mouthPress*", 0.3f}}}},
    {"sad", "Sorrow", {{{"browInnerUp", 0.7f}, {"mouthFrown*", 0.6f}, {"mouthShrugLower", 0.3f}}}},
    {"relaxed", "Fun", {{{"mouthSmile*", 0.4f}, {"eyeSquint*", 0.2f}}}},
    {"surprised",
     "Surprised",
     {{{"browInnerUp", 0.6f}, {"browOuterUp*", 0.7f}, {"eyeWide*", 0.6f}, {"jawOpen", 0.25f}}}},
    {"lookUp", "LookUp", {{{"eyeLookUp*", 1}}}},
    {"lookDown", "LookDown", {{{"eyeLookDown*", 1}}}},
    {"lookLeft", "LookLeft", {{{"eyeLookOutLeft", 1}, {"eyeLookInRight", 1}}}},
    {"lookRight", "LookRight", {{{"eyeLookInLeft", 1}, {"eyeLookOutRight", 1}}}}};
constexpr size_t kCount = std::size(kExpressions);

// VRM 1's names, then VRM 0's.
std::vector<std::string_view> Names() {
  std::vector<std::string_view> names(2 * kCount);
  for (size_t i = 0; i < kCount; ++i) {
    names[i] = kExpressions[i].vrm1;
    names[kCount + i] = kExpressions[i].vrm0;
  }
  return names;
}

}  // namespace

VrmExpressions::VrmExpressions(const BlendshapeMap& map) : index_(Names()), parts_(kCount) {
  const BlendshapeIndex scores(map.names);
  for (size_t i = 0; i < kCount; ++i)
    for (const Score& score : kExpressions[i].scores) {
      const std::string_view name = score.name;
      const auto add = [&](std::string_view side) {
        const std::string whole = std::string(name.substr(0, name.find('*'))).append(side);
        if (const int place = name.empty() ? -1 : scores.Find(whole); place >= 0)
          parts_[i].push_back({size_t(place), score.score});
      };
      if (!name.ends_with('*')) {
        add("");
      } else {
        add("Left");
        add("Right");
      }
    }
}

int VrmExpressions::Find(std::string_view name) const {
  const int place = index_.Find(name);
  const int expression = place < int(kCount) ? place : place - int(kCount);
  return expression < 0 || parts_[size_t(expression)].empty() ? -1 : expression;
}

void VrmExpressions::Add(const std::vector<float>& weights, std::vector<float>& scores) const {
  for (size_t i = 0; i < parts_.size(); ++i)
    for (const auto& [place, score] : parts_[i])
      scores[place] = std::min(1.0f, scores[place] + weights[i] * score);
}

}  // namespace cosplat
