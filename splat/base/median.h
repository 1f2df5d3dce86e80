// The middle of numbers.
#pragma once

#include <algorithm>
#include <iterator>

namespace cosplat {

// The upper one of the two middle values where their number is even; 0 if there is none. Changes
// their order.
template <class Values>
typename Values::value_type Median(Values& values) {
  if (values.empty()) return {};
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace cosplat
