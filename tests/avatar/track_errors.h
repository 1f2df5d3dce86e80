// Errors of a track, as fitting landmarks leaves them, and how large they are.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "flame/track.h"
#include "splat/base/rng.h"

namespace cosplat::test {

// Normal errors of these sizes on every training frame: as fitting landmarks leaves them.
inline constexpr float kExpressionError = 0.15f;
inline constexpr float kPoseError = 0.02f;          // radians, of root and jaw
inline constexpr float kTranslationError = 0.002f;  // metres

inline void Perturb(TrackedVideo& video) {
  Rng rng{5};
  for (TrackedFrame& frame : video.train) {
    for (float& x : frame.params.expression) x += kExpressionError * rng.Normal();
    for (const int joint : {0, 2})
      for (float& x : frame.params.pose[joint]) x += kPoseError * rng.Normal();
    for (float& x : frame.params.translation) x += kTranslationError * rng.Normal();
  }
}

// Root mean square difference over frames, of expression, of root and jaw, of translation. Each
// number's mean over the frames is left out: the avatar absorbs it.
inline std::array<double, 3> Distance(const std::vector<FlameParams>& a,
                                      const std::vector<TrackedFrame>& truth) {
  std::array<double, 3> distance{};
  const auto add = [&](int group, double share, const auto& number) {
    double sum = 0, squares = 0;
    for (size_t f = 0; f < a.size(); ++f) {
      const double d = number(a[f]) - number(truth[f].params);
      sum += d;
      squares += d * d;
    }
    const double n = double(a.size());
    distance[group] += share * (squares / n - sum / n * sum / n);
  };
  const size_t expressions = truth[0].params.expression.size();
  for (size_t k = 0; k < expressions; ++k)
    add(0, 1.0 / double(expressions), [&](const FlameParams& p) { return p.expression[k]; });
  for (const int joint : {0, 2})
    for (int k = 0; k < 3; ++k)
      add(1, 1.0 / 6, [&](const FlameParams& p) { return p.pose[joint][k]; });
  for (int k = 0; k < 3; ++k)
    add(2, 1.0 / 3, [&](const FlameParams& p) { return p.translation[k]; });
  for (double& d : distance) d = std::sqrt(d);
  return distance;
}

}  // namespace cosplat::test
