#include "flame/blendshape_names.h"

#include <algorithm>

namespace cosplat {

// clang-format off
const std::array<std::string_view, kArkitBlendshapes> kArkitNames = {
    "eyeBlinkLeft", "eyeLookDownLeft", "eyeLookInLeft", "eyeLookOutLeft", "eyeLookUpLeft",
    "eyeSquintLeft", "eyeWideLeft", "eyeBlinkRight", "eyeLookDownRight", "eyeLookInRight",
    "eyeLookOutRight", "eyeLookUpRight", "eyeSquintRight", "eyeWideRight", "jawForward", "jawRight",
    "jawLeft", "jawOpen", "mouthClose", "mouthFunnel", "mouthPucker", "mouthRight", "mouthLeft",
    "mouthSmileLeft", "mouthSmileRight", "mouthFrownLeft", "mouthFrownRight", "mouthDimpleLeft",
    "mouthDimpleRight", "mouthStretchLeft", "mouthStretchRight", "mouthRollLower", "mouthRollUpper",
    "mouthShrugLower", "mouthShrugUpper", "mouthPressLeft", "mouthPressRight", "mouthLowerDownLeft",
    "mouthLowerDownRight", "mouthUpperUpLeft", "mouthUpperUpRight", "browDownLeft", "browDownRight",
    "browInnerUp", "browOuterUpLeft", "browOuterUpRight", "cheekPuff", "cheekSquintLeft",
    "cheekSquintRight", "noseSneerLeft", "noseSneerRight", "tongueOut",
};
// clang-format on

namespace {

constexpr std::string_view kSeparators = "_-. ";

// ASCII only, independent of the locale.
bool IsUpper(char c) { return c >= 'A' && c <= 'Z'; }
bool IsLower(char c) { return c >= 'a' && c <= 'z'; }
char Lower(char c) { return IsUpper(c) ? char(c - 'A' + 'a') : c; }

// The end of the word that begins at `begin`: a separator, or a capital after a small letter.
size_t WordEnd(std::string_view name, size_t begin) {
  for (size_t i = begin + 1; i < name.size(); ++i)
    if (kSeparators.find(name[i]) != name.npos || (IsUpper(name[i]) && IsLower(name[i - 1])))
      return i;
  return name.size();
}

}  // namespace

bool SameIgnoringCase(std::string_view a, std::string_view b) {
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return Lower(x) == Lower(y); });
}

std::string NormalName(std::string_view name) {
  std::string rest, sides;
  for (size_t begin = 0; begin < name.size();) {
    if (kSeparators.find(name[begin]) != name.npos) {
      ++begin;
      continue;
    }
    const size_t end = WordEnd(name, begin);
    const std::string_view word = name.substr(begin, end - begin);
    begin = end;
    if (SameIgnoringCase(word, "l") || SameIgnoringCase(word, "left"))
      sides += "left";
    else if (SameIgnoringCase(word, "r") || SameIgnoringCase(word, "right"))
      sides += "right";
    else
      std::transform(word.begin(), word.end(), std::back_inserter(rest), Lower);
  }
  rest += sides;
  return rest.empty() ? std::string(name) : rest;
}

int BlendshapeIndex::Find(std::string_view name) const {
  const auto found = by_normal_name_.find(NormalName(name));
  return found == by_normal_name_.end() ? -1 : found->second;
}

int FindArkitBlendshape(std::string_view name) {
  static const BlendshapeIndex index(kArkitNames);
  return index.Find(name);
}

std::string ArkitSpelling(const std::string& name) {
  const int i = FindArkitBlendshape(name);
  return i < 0 ? name : std::string(kArkitNames[size_t(i)]);
}

}  // namespace cosplat
