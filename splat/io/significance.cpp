#include "splat/io/significance.h"

#include <algorithm>
#include <cmath>

namespace cosplat {

std::vector<float> SizeSignificance(const Gaussians& g) {
  std::vector<float> significance;
  for (size_t i = 0; i < g.size(); ++i) {
    const float* s = g.at(kScaleLog, i);
    const float opacity = 1 / (1 + std::exp(-*g.at(kOpacityLogit, i)));
    significance.push_back(opacity * std::exp((s[0] + s[1] + s[2]) / 3));
  }
  return significance;
}

std::vector<float> WeightsOf(View<const float> significance) {
  std::vector<float> finite;
  for (const float s : significance) finite.push_back(std::isfinite(s) ? s : 0);
  double sum = 0;
  for (const float s : finite) sum += s;
  const float least = sum > 0 ? float(1e-4 * sum / double(finite.size())) : 1;
  std::vector<float> weights;
  for (const float s : finite) weights.push_back(std::max(s, least));
  return weights;
}

}  // namespace cosplat
