// The most recent durations of an operation, for a graph.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "splat/base/median.h"

namespace cosplat::viewer {

class TimeHistory {
 public:
  static constexpr size_t kLength = 150;

  void Add(float milliseconds) {
    values_[next_] = milliseconds;
    next_ = (next_ + 1) % kLength;
    count_ = std::min(count_ + 1, kLength);
  }
  // Oldest first.
  std::vector<float> Values() const {
    std::vector<float> values;
    for (size_t i = kLength - count_; i < kLength; ++i)
      values.push_back(values_[(next_ + i) % kLength]);
    return values;
  }
  // 0 if empty.
  float Median() const {
    std::vector<float> values = Values();
    return cosplat::Median(values);
  }

 private:
  std::array<float, kLength> values_{};
  size_t next_ = 0, count_ = 0;
};

}  // namespace cosplat::viewer
