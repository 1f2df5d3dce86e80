// A linear map from ARKit's blendshapes to FLAME's parameters, read from a user-provided file.
//
// matrix.npz -> BlendshapeMatrix -> VmcSource.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "flame/model.h"

namespace cosplat {

// The 52 blendshapes of Apple's ARKit, the common output of face trackers.
constexpr size_t kArkitBlendshapes = 52;

// In the order in which Live Link Face writes them, which is also the row order of a matrix file.
extern const std::array<std::string_view, kArkitBlendshapes> kArkitNames;

// Case-insensitive, because senders differ; -1 for an unknown name.
int FindArkitBlendshape(std::string_view name);

using BlendshapeWeights = std::array<float, kArkitBlendshapes>;  // 0 to 1

class BlendshapeMatrix {
 public:
  // Reads an .npz with `expression` [52, E] and, optionally, `jaw`, `left_eye` and `right_eye`
  // [52, 3], axis-angle. Throws Error naming file and array when a shape is wrong, a number is not
  // finite, or the absolute values of a column add up to more than kMaxParameter.
  static BlendshapeMatrix Read(const std::string& path);

  // Sets expression, jaw and eyes.
  void Apply(const BlendshapeWeights& weights, FlameParams& params) const;

 private:
  size_t expression_count_ = 0;
  std::vector<float> expression_;             // [52, E]
  std::array<std::vector<float>, 3> joints_;  // jaw, left eye, right eye: [52, 3], or empty
};

}  // namespace cosplat
