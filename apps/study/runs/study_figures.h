// The figures of a study: their names, formatting and direction. Used by charts and tables.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/study/runs/study_statistics.h"

namespace cosplat {

struct StudyFigure {
  std::string key;  // in a study line
  std::string name, unit;
  int decimals = 0;
  bool less_is_better = false;
};

// Image quality and cost figures: those that some point has, in column order. LPIPS is a separate
// figure per network.
std::vector<StudyFigure> QualitiesIn(const std::vector<StudyPoint>& points);
std::vector<StudyFigure> CostsIn(const std::vector<StudyPoint>& points);

// The key of `quality` to plot against `cost`. For the size of the SOG, it is the quality of the
// images drawn from it, or empty if that was not measured.
std::string QualityKeyFor(const StudyFigure& quality, const StudyFigure& cost);

// "31.70 ± 0.05"; without an error for a single seed; "-" for nullopt.
std::string ToString(const std::optional<Estimate>& estimate, int decimals);
// The same for a difference, with its sign: "+0.52 ± 0.05".
std::string SignedText(const std::optional<Estimate>& difference, int decimals);

}  // namespace cosplat
