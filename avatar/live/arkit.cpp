#include <algorithm>

#include "avatar/live/blendshape_matrix.h"

namespace cosplat {
namespace {

// ASCII only, independent of the locale.
char Lower(char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; }

bool SameName(std::string_view a, std::string_view b) {
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return Lower(x) == Lower(y); });
}

}  // namespace

const std::array<std::string_view, kArkitBlendshapes> kArkitNames = {"eyeBlinkLeft",
                                                                     "eyeLookDownLeft",
                                                                     "eyeLookInLeft",
                                                                     "eyeLookOutLeft",
                                                                     "eyeLookUpLeft",
                                                                     "eyeSquintLeft",
                                                                     "eyeWideLeft",
                                                                     "eyeBlinkRight",
                                                                     "eyeLookDownRight",
                                                                     "eyeLookInRight",
                                                                     "eyeLookOutRight",
                                                                     "eyeLookUpRight",
                                                                     "eyeSquintRight",
                                                                     "eyeWideRight",
                                                                     "jawForward",
                                                                     "jawRight",
                                                                     "jawLeft",
                                                                     "jawOpen",
                                                                     "mouthClose",
                                                                     "mouthFunnel",
                                                                     "mouthPucker",
                                                                     "mouthRight",
                                                                     "mouthLeft",
                                                                     "mouthSmileLeft",
                                                                     "mouthSmileRight",
                                                                     "mouthFrownLeft",
                                                                     "mouthFrownRight",
                                                                     "mouthDimpleLeft",
                                                                     "mouthDimpleRight",
                                                                     "mouthStretchLeft",
                                                                     "mouthStretchRight",
                                                                     "mouthRollLower",
                                                                     "mouthRollUpper",
                                                                     "mouthShrugLower",
                                                                     "mouthShrugUpper",
                                                                     "mouthPressLeft",
                                                                     "mouthPressRight",
                                                                     "mouthLowerDownLeft",
                                                                     "mouthLowerDownRight",
                                                                     "mouthUpperUpLeft",
                                                                     "mouthUpperUpRight",
                                                                     "browDownLeft",
                                                                     "browDownRight",
                                                                     "browInnerUp",
                                                                     "browOuterUpLeft",
                                                                     "browOuterUpRight",
                                                                     "cheekPuff",
                                                                     "cheekSquintLeft",
                                                                     "cheekSquintRight",
                                                                     "noseSneerLeft",
                                                                     "noseSneerRight",
                                                                     "tongueOut"};

int FindArkitBlendshape(std::string_view name) {
  for (size_t i = 0; i < kArkitNames.size(); ++i)
    if (SameName(name, kArkitNames[i])) return int(i);
  return -1;
}

}  // namespace cosplat
