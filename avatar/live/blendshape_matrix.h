// A linear map from ARKit's blendshapes to FLAME's parameters: the file that a user brings.
//
// matrix.npz -> BlendshapeMatrix -> VmcSource.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "flame/model.h"

namespace cosplat {

// The 52 blendshapes of Apple's ARKit, which face trackers speak.

constexpr size_t kArkitBlendshapes = 52;

// In the order in which Apple's Live Link Face writes them; rows of a matrix file are in it.
extern const std::array<std::string_view, kArkitBlendshapes> kArkitNames;

// Upper and lower case alike, since senders differ; -1 for a name that is none.
int FindArkitBlendshape(std::string_view name);

using BlendshapeWeights = std::array<float, kArkitBlendshapes>;  // 0 to 1

class BlendshapeMatrix {
 public:
  // An .npz with `expression` [52, E] and, where there are any, `jaw`, `left_eye` and `right_eye`
  // [52, 3], axis times angle. Throws Error naming file and array when a shape is another, a number
  // is not finite, or weights could add up beyond what a face can have.
  static BlendshapeMatrix Read(const std::string& path);

  // Sets expression, jaw and eyes.
  void Apply(const BlendshapeWeights& weights, FlameParams& params) const;

 private:
  size_t expression_count_ = 0;
  std::vector<float> expression_;             // [52, E]
  std::array<std::vector<float>, 3> joints_;  // jaw, left eye, right eye: [52, 3], or empty
};

}  // namespace cosplat
