// The figures of a study: how each is named, written and judged. Charts and tables follow it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/study/runs/study_statistics.h"

namespace cosplat {

struct StudyFigure {
  std::string key;  // in a line
  std::string name, unit;
  int decimals = 0;
  bool less_is_better = false;
};

// How good the images are, what it costs: those that some point has, in the order of columns.
// LPIPS is a figure of its own per net.
std::vector<StudyFigure> QualitiesIn(const std::vector<StudyPoint>& points);
std::vector<StudyFigure> CostsIn(const std::vector<StudyPoint>& points);

// The key of a quality where the cost is that of the quantised file, whose images are others;
// empty where it was not measured of that.
std::string QualityKeyFor(const StudyFigure& quality, const StudyFigure& cost);

// "31.70 ± 0.05", without an error for a single seed; "-" for none.
std::string ToString(const std::optional<Estimate>& estimate, int decimals);
// The same of a difference, with its sign: "+0.52 ± 0.05".
std::string SignedText(const std::optional<Estimate>& difference, int decimals);

}  // namespace cosplat
