#include "avatar/live/packet_input.h"

namespace cosplat {

void TakeScores(const BlendshapeScores& scores,
                const std::vector<std::string>& dropped,
                const BlendshapeIndex& index,
                const std::string& description,
                std::vector<float>& values,
                LiveCounts& counts) {
  values.assign(values.size(), 0.0f);
  for (const auto& [name, score] : scores)
    if (const int i = FindScore(index, name, counts.unused); i >= 0) values[size_t(i)] = score;
  for (const std::string& name : dropped) {
    ++counts.malformed;
    counts.unused.dropped.Count(name);
    counts.last_problem = description + ": blendshapes." + PrintableName(name) +
                          ": is not a score, a number from 0 to 1";
  }
}

}  // namespace cosplat
