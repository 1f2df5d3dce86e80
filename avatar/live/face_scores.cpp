#include "avatar/live/face_scores.h"

#include <algorithm>
#include <cmath>

namespace cosplat {
namespace {

// A coefficient counts as much as 0.1 rad, as for smoothing (avatar/live/smoother.h).
constexpr float kPerRadian = 10;
// Of the squared scores: decides between scores that do the same, and shrinks others by a
// thousandth at most where they move anything that is seen.
constexpr float kRidge = 1e-4f;
// The general map takes a few; a random one of 52 scores for 69 outputs is met to 1e-3 after 500.
constexpr int kSweeps = 500;
constexpr float kSettled = 1e-5f;  // the largest change of a score in a sweep that ends them

// What the face is beyond the map's offset, in units that count alike.
std::vector<float> Wanted(const BlendshapeMap& map, const FlameParams& params) {
  const size_t expressions = map.expression_count();
  std::vector<float> wanted(map.offset.size());
  for (size_t o = 0; o < wanted.size(); ++o) {
    constexpr size_t kJaw = 2;  // in FlameParams::pose; the eyes follow
    const size_t turn = o - expressions;
    const float value = o >= expressions               ? params.pose[kJaw + turn / 3][turn % 3]
                        : o < params.expression.size() ? params.expression[o]
                                                       : 0;
    wanted[o] = (value - map.offset[o]) * (o >= expressions ? kPerRadian : 1);
  }
  return wanted;
}

}  // namespace

BlendshapeScores ScoresOf(const BlendshapeMap& map, const FlameParams& params) {
  const size_t width = map.offset.size(), count = map.names.size();
  std::vector<float> rows = map.matrix, rest = Wanted(map, params), scores(count), norms(count);
  for (size_t c = 0; c < count; ++c)
    for (size_t o = 0; o < width; ++o) {
      float& value = rows[c * width + o];
      if (o >= map.expression_count()) value *= kPerRadian;
      norms[c] += value * value;
    }
  float change = 1;
  for (int sweep = 0; sweep < kSweeps && change > kSettled; ++sweep) {
    change = 0;
    for (size_t c = 0; c < count; ++c) {
      const float* row = &rows[c * width];
      float along = scores[c] * norms[c];
      for (size_t o = 0; o < width; ++o) along += row[o] * rest[o];
      const float score = std::clamp(along / (norms[c] + kRidge), 0.0f, 1.0f);
      for (size_t o = 0; o < width; ++o) rest[o] -= (score - scores[c]) * row[o];
      change = std::max(change, std::abs(score - scores[c]));
      scores[c] = score;
    }
  }
  BlendshapeScores named;
  for (size_t c = 0; c < count; ++c) named[map.names[c]] = scores[c];
  return named;
}

}  // namespace cosplat
