// A way in which splatting is known to fail, measured: what the naive form makes of it beside what
// ours does, and the bound that a test holds ours to.
//
// SplatStability() (apps/study/stability/cases.h) and its like for avatars make the cases;
// tests/*/stability_test.cpp hold them to their bounds, `cosplat study --stability` shows them.
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
  double value = 0;  // of the case's quantity; may be infinite or not a number
  Image8 image;      // RGB, at most 200 px a side; may be empty
};

// Where a curve says more than two images. Points that a logarithm does not have are left out.
struct StabilityCurve {
  std::string name;
  std::vector<std::array<double, 2>> points;  // x, y; joined in their order
};
struct StabilityChart {
  std::string x_name, x_unit, y_name, y_unit;  // units may be empty
  bool x_log = false, y_log = false;
  std::vector<StabilityCurve> curves;
};

struct StabilityCase {
  std::string key;       // snake_case, unique among all cases
  std::string title;     // "The jump of the arctangent"
  std::string what;      // two sentences at most: what goes wrong where, how it is measured
  std::string quantity;  // what the numbers are: "largest jump of the colour over 1e-6 rad"
  std::string unit;      // may be empty
  StabilityForm naive, ours;
  double bound = 0;       // ours is at most this, the naive form is not
  bool at_least = false;  // or: ours is at least this, the naive form is not
  StabilityChart chart;   // no curves: none
};

// Whether a value of the case's quantity is within its bound; one that is not a number is not.
inline bool IsWithinBound(const StabilityCase& c, double value) {
  return c.at_least ? value >= c.bound : value <= c.bound;
}

// The larger of two errors; infinite where one is not a number, which std::max may pass over.
inline double LargerError(double a, double b) {
  return std::isnan(a) || std::isnan(b) ? INFINITY : std::max(a, b);
}

}  // namespace cosplat
