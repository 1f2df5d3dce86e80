#include "avatar/model/blendshape_map.h"

#include <algorithm>
#include <cmath>

#include "avatar/math/one_euro.h"

namespace cosplat {
namespace {

// The most that a score can exceed its range, as a fraction of the range's width.
constexpr float kScoreMargin = 0.25f;

// What a score of 1 turns in GeneralBlendshapeMap, radians. A mouth opens by 40 to 50 mm, which is
// half a radian 9 cm from the joint. Gaze: two thirds of the 30 degrees that eyes turn before the
// head does; a published head with ARKit's blendshapes has 12 to 23 degrees.
constexpr float kJawOpen = 0.5f, kJawAside = 0.1f, kGazeAside = 0.4f, kGazeUp = 0.3f;

// Positions in the turns.
enum : size_t { kJawDown = 0, kJawLeft = 1, kLeftEye = 3, kRightEye = 6 };

struct GeneralTurn {
  const char* name;
  size_t turn;
  float radians;
};
// FLAME's axes: x turns down, y towards the subject's left. "In" is towards the nose.
constexpr GeneralTurn kGeneralTurns[] = {{"jawOpen", kJawDown, kJawOpen},
                                         {"jawLeft", kJawLeft, kJawAside},
                                         {"jawRight", kJawLeft, -kJawAside},
                                         {"eyeLookDownLeft", kLeftEye, kGazeUp},
                                         {"eyeLookUpLeft", kLeftEye, -kGazeUp},
                                         {"eyeLookInLeft", kLeftEye + 1, -kGazeAside},
                                         {"eyeLookOutLeft", kLeftEye + 1, kGazeAside},
                                         {"eyeLookDownRight", kRightEye, kGazeUp},
                                         {"eyeLookUpRight", kRightEye, -kGazeUp},
                                         {"eyeLookInRight", kRightEye + 1, kGazeAside},
                                         {"eyeLookOutRight", kRightEye + 1, -kGazeAside}};

float Limited(const BlendshapeMap& map, size_t c, float score) {
  const float min = map.min[c], max = map.max[c];
  const float margin = kScoreMargin * (max - min);
  return math::SoftClamp(std::clamp(score, 0.0f, 1.0f), min, max, margin);
}

std::string SizeProblem(const char* field, size_t found, size_t expected) {
  if (found == expected) return "";
  return std::string(field) + ": has " + std::to_string(found) + " numbers, expected " +
         std::to_string(expected);
}

std::string NumberProblem(const char* field, const std::vector<float>& numbers) {
  for (size_t i = 0; i < numbers.size(); ++i)
    if (!std::isfinite(numbers[i]))
      return std::string(field) + ": number " + std::to_string(i) + " is not finite";
  return "";
}

std::string NameProblem(const std::vector<std::string>& names) {
  const BlendshapeIndex index(names);
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty()) return "names: number " + std::to_string(i) + " is empty";
    const int first = index.Find(names[i]);
    if (size_t(first) < i)
      return "names: '" + names[i] + "' is number " + std::to_string(first) + " and " +
             std::to_string(i);
  }
  return "";
}

std::string RangeProblem(const BlendshapeMap& map) {
  for (size_t c = 0; c < map.names.size(); ++c)
    if (!(0 <= map.min[c] && map.min[c] < map.max[c] && map.max[c] <= 1))
      return "most: that of '" + map.names[c] + "' is " + std::to_string(map.max[c]) +
             ", its least " + std::to_string(map.min[c]) + ", expected a range within 0 to 1";
  return "";
}

std::string ReachProblem(const BlendshapeMap& map) {
  const size_t width = map.offset.size();
  for (size_t o = 0; o < width; ++o) {
    double reach = std::abs(map.offset[o]);
    for (size_t c = 0; c < map.names.size(); ++c)
      reach += double(std::abs(map.matrix[c * width + o])) * Limited(map, c, 1);
    if (!(reach <= kMaxMapped))
      return "matrix: absolute values of column " + std::to_string(o) + " add up to " +
             std::to_string(reach) + ", at most " + std::to_string(int(kMaxMapped)) + " is allowed";
  }
  return "";
}

}  // namespace

std::string ProblemOf(const BlendshapeMap& map) {
  const size_t count = map.names.size();
  if (map.offset.size() < kMappedTurns)
    return "offset: has " + std::to_string(map.offset.size()) + " numbers, expected at least " +
           std::to_string(kMappedTurns);
  const BlendshapeFitFigures& fit = map.fit;
  const std::string problems[] = {
      SizeProblem("least", map.min.size(), count),
      SizeProblem("most", map.max.size(), count),
      SizeProblem("matrix", map.matrix.size(), count * map.offset.size()),
      NumberProblem("least", map.min),
      NumberProblem("most", map.max),
      NumberProblem("offset", map.offset),
      NumberProblem("matrix", map.matrix),
      NumberProblem("fit", {fit.r2, fit.error, fit.mean_face_error}),
      NameProblem(map.names)};
  for (const std::string& problem : problems)
    if (!problem.empty()) return problem;
  const std::string range = RangeProblem(map);
  return range.empty() ? ReachProblem(map) : range;
}

int FindBlendshape(const BlendshapeMap& map, std::string_view name) {
  return BlendshapeIndex(map.names).Find(name);
}

void ApplyBlendshapes(const BlendshapeMap& map,
                      const std::vector<float>& scores,
                      FlameParams& params) {
  const size_t width = map.offset.size(), expressions = map.expression_count();
  params.expression.assign(map.offset.begin(), map.offset.end() - std::ptrdiff_t(kMappedTurns));
  std::array<float, kMappedTurns> turns;
  std::copy_n(map.offset.end() - std::ptrdiff_t(kMappedTurns), kMappedTurns, turns.begin());
  for (size_t c = 0; c < map.names.size(); ++c) {
    const float score = Limited(map, c, scores[c]);
    const float* row = &map.matrix[c * width];
    for (size_t e = 0; e < expressions; ++e) params.expression[e] += score * row[e];
    for (size_t t = 0; t < kMappedTurns; ++t) turns[t] += score * row[expressions + t];
  }
  constexpr size_t kJaw = 2;  // the jaw in FlameParams::pose; the eyes follow
  for (size_t t = 0; t < kMappedTurns; ++t) params.pose[kJaw + t / 3][t % 3] = turns[t];
}

void ApplyBlendshapes(const BlendshapeMap& map,
                      const BlendshapeScores& scores,
                      FlameParams& params) {
  const BlendshapeIndex index(map.names);
  std::vector<float> ordered(map.names.size());
  for (const auto& [name, score] : scores)
    if (const int i = index.Find(name); i >= 0) ordered[size_t(i)] = score;
  ApplyBlendshapes(map, ordered, params);
}

BlendshapeMap GeneralBlendshapeMap(const FlameModel* flame) {
  const size_t expressions = flame ? size_t(flame->expression_count) : 0;
  BlendshapeMap map;
  map.offset.assign(expressions + kMappedTurns, 0.0f);
  const auto add = [&](const std::string& name, size_t output, float value) {
    const size_t row =
        size_t(std::find(map.names.begin(), map.names.end(), name) - map.names.begin());
    if (row == map.names.size()) {
      map.names.push_back(name);
      map.min.push_back(0);
      map.max.push_back(1);
      map.matrix.resize(map.names.size() * map.offset.size());
    }
    map.matrix[row * map.offset.size() + output] = value;
  };
  for (const GeneralTurn& turn : kGeneralTurns)
    add(turn.name, expressions + turn.turn, turn.radians);
  if (flame && flame->has_eyelids) {
    add("eyeBlinkLeft", expressions - 2, 1);
    add("eyeBlinkRight", expressions - 1, 1);
  }
  for (size_t e = 0; flame && e < flame->expression_names.size(); ++e)
    if (const std::string& name = flame->expression_names[e]; !name.empty())
      add(name, e, flame->expression_scores[e]);
  return map;
}

}  // namespace cosplat
