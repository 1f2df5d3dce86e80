// A measured failure case of splatting: the result of the naive form, ours, and the bound that a
// test checks ours against.
//
// SplatStability() (apps/study/stability/cases.h) and AvatarStability() make the cases;
// tests/*/stability_test.cpp check them against their bounds, `cosplat-study --stability` shows
// them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

struct StabilityForm {
  std::string name;  // "arctan(y/x), as the paper writes it"
  double value = 0;  // of the case's quantity; may be non-finite
  Image8 image;      // RGB, at most 200 px a side; may be empty
};

// Used where a curve tells more than two images. Points not representable on a logarithmic axis are
// omitted.
struct StabilityCurve {
  std::string name;
  std::vector<std::array<double, 2>> points;  // x, y; joined in order
};
struct StabilityChart {
  std::string x_name, x_unit, y_name, y_unit;  // units may be empty
  bool x_log = false, y_log = false;
  std::vector<StabilityCurve> curves;
};

struct StabilityCase {
  std::string key;       // snake_case, unique among all cases
  std::string title;     // "The jump of the arctangent"
  std::string what;      // at most two sentences: what goes wrong where, how it is measured
  std::string quantity;  // what is measured: "largest jump of the colour over 1e-6 rad"
  std::string unit;      // may be empty
  StabilityForm naive, ours;
  double bound = 0;       // upper bound that ours satisfies and the naive form does not
  bool at_least = false;  // `bound` is a lower bound instead
  StabilityChart chart;   // none if it has no curves
};

// Whether a value of the case's quantity satisfies its bound; NaN does not.
inline bool IsWithinBound(const StabilityCase& c, double value) {
  return c.at_least ? value >= c.bound : value <= c.bound;
}

// The larger of two errors; infinite if one is NaN, which std::max may ignore.
inline double LargerError(double a, double b) {
  return std::isnan(a) || std::isnan(b) ? INFINITY : std::max(a, b);
}

}  // namespace cosplat
