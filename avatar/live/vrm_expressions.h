// VRM's expressions as ARKit's scores, for senders whose model has no others.
//
// OSC "Joy", 0.7 -> VrmExpressions -> the scores of a BlendshapeMap; docs/live-input.md has the
// table. Names: vrm.dev, VRM 0's presets and VRM 1's.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "avatar/model/blendshape_map.h"

namespace cosplat {

class VrmExpressions {
 public:
  explicit VrmExpressions(const BlendshapeMap& map);

  // The place of an expression, by either version's name in any spelling; -1 if it is none, or the
  // map has no score of it.
  int Find(std::string_view name) const;
  size_t size() const { return parts_.size(); }
  // Adds to `scores`, in the order of the map's names, what expressions of these weights are; none
  // exceeds 1.
  void Add(const std::vector<float>& weights, std::vector<float>& scores) const;

 private:
  struct Part {
    size_t place;  // of the score
    float score;   // at a weight of 1
  };
  BlendshapeIndex index_;
  std::vector<std::vector<Part>> parts_;  // of each expression
};

}  // namespace cosplat
