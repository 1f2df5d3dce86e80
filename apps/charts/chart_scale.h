// Axis of a chart: positions of values, choice of ticks and their labels.
#pragma once

#include <string>
#include <vector>

namespace cosplat {

class ChartScale {
 public:
  // Covers `values` and ends on round numbers (1, 2, 5 times a power of ten); a linear scale that
  // would begin near zero begins at zero. `from_zero`, for bars: always begins at zero.
  ChartScale(std::vector<double> values, bool log, bool from_zero);
  // Position as a fraction of the axis length.
  double operator()(double value) const;
  const std::vector<double>& ticks() const { return ticks_; }

 private:
  void FitLinear(bool from_zero);
  void FitLog();

  bool log_;
  double low_ = 0, high_ = 1;
  std::vector<double> ticks_;
};

// Rounded to significant digits, with k and M: 0.25, 12, 1.5k, 1M.
std::string ShortNumber(double value, int digits = 3);

// Short numbers with as many digits as needed to distinguish neighbouring ticks.
std::vector<std::string> TickTexts(const std::vector<double>& ticks);

}  // namespace cosplat
