// Small charts as SVG: lines, points and bars on linear or logarithmic axes. Self-contained, on
// white, readable at its natural size; used by `bench`, `report` and `study`.
#pragma once

#include <string>
#include <vector>

namespace cosplat {

struct Axis {
  std::string name;
  std::string unit;  // may be empty
  bool log = false;  // values must be > 0
};

struct Mark {
  double x = 0, y = 0;
  std::string label;  // beside the point; may be empty. Of bars: the category
  // Not of bars: half the length of error bars, none where 0; a ring around the point.
  double x_error = 0, y_error = 0;
  bool ringed = false;
};

struct ChartSeries {
  std::string name;
  std::vector<Mark> marks;
};

struct Chart {
  enum class Kind {
    kLines,   // points joined in their order
    kPoints,  // points alone
    // A bar of length x per mark, grouped by label, one below the other; y is not used. On a
    // logarithmic axis, which has no zero for a bar to begin at, a dot on a line.
    kBars
  };
  Kind kind = Kind::kLines;
  std::string title;
  Axis x, y;
  std::vector<ChartSeries> series;
  std::vector<ChartSeries> guides;  // dashed lines to compare with, all shown; not with bars
};

// Marks that are not finite, or not positive on a logarithmic axis, are left out.
std::string ToSvg(const Chart& chart);

}  // namespace cosplat
