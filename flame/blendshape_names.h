// The names of blendshape scores, and the one rule by which two spellings are the same name.
//
// a tracker's or a file's names -> NormalName -> BlendshapeIndex -> the scores of a BlendshapeMap.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>

namespace cosplat {

// The 52 blendshapes of Apple's ARKit, the common output of face trackers.
constexpr size_t kArkitBlendshapes = 52;

// In the order in which Live Link Face writes them, which is also the row order of a matrix file.
extern const std::array<std::string_view, kArkitBlendshapes> kArkitNames;

// Ignores the case of ASCII's letters.
bool SameIgnoringCase(std::string_view a, std::string_view b);

// Equal for all spellings of a name: "mouthSmileLeft", "MouthSmileLeft", "mouth_smile_left",
// "MOUTH-SMILE-LEFT" and, as ARKit's own constants and iFacialMocap have it, "mouthSmile_L". Small
// letters without separators, the side in full and at the end, wherever it was.
std::string NormalName(std::string_view name);

// Finds the place of a name in a list, in any spelling.
class BlendshapeIndex {
 public:
  // The first of several names with equal normal names counts.
  template <class Names>
  explicit BlendshapeIndex(const Names& names) {
    int place = 0;
    for (const auto& name : names) by_normal_name_.emplace(NormalName(name), place++);
  }
  // -1 for an unknown name.
  int Find(std::string_view name) const;

 private:
  std::map<std::string, int, std::less<>> by_normal_name_;
};

// Its row in kArkitNames, or -1.
int FindArkitBlendshape(std::string_view name);
// One of the 52 as ARKit writes it; other names unchanged.
std::string ArkitSpelling(const std::string& name);

}  // namespace cosplat
