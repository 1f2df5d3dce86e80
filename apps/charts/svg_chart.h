// Small charts as SVG: lines, points and bars on linear or logarithmic axes. Self-contained, white
// background, readable at natural size; used by `bench`, `report` and `study`.
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
  std::string label;  // next to the point, may be empty; for bars: the category
  // Not for bars: half the length of the error bars (0: none), and a ring around the point.
  double x_error = 0, y_error = 0;
  bool ringed = false;
};

struct ChartSeries {
  std::string name;
  std::vector<Mark> marks;
};

struct Chart {
  enum class Kind {
    kLines,   // points joined in order
    kPoints,  // points only
    // One bar of length x per mark, grouped by label, stacked vertically; y is unused. A
    // logarithmic axis has no zero at which a bar could begin, so it shows dots on lines instead.
    kBars
  };
  Kind kind = Kind::kLines;
  std::string title;
  Axis x, y;
  std::vector<ChartSeries> series;
  std::vector<ChartSeries> guides;  // dashed reference lines, always fully visible; not with bars
};

// Omits marks that are non-finite, or not positive on a logarithmic axis.
std::string ToSvg(const Chart& chart);

}  // namespace cosplat
