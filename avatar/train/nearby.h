// Guesses what is not known at a vertex from vertices where it is.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace cosplat {

// The mean of `values` at the vertices `known` (not empty), weighted by exp(-d / sigma): d is how
// much farther distance(vertex) is than that of the nearest.
template <class T, class Distance>
T Nearby(const std::vector<size_t>& known,
         const std::vector<T>& values,
         float sigma,
         const Distance& distance) {
  std::vector<float> distances;
  for (const size_t v : known) distances.push_back(distance(v));
  const float nearest = *std::min_element(distances.begin(), distances.end());
  T sum{};
  float total = 0;
  for (size_t i = 0; i < known.size(); ++i) {
    const float weight = std::exp((nearest - distances[i]) / sigma);
    sum = sum + values[known[i]] * weight;
    total += weight;
  }
  return sum * (1 / total);
}

}  // namespace cosplat
