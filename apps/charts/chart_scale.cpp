#include "apps/charts/chart_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cosplat {
namespace {

constexpr double kSlack = 1e-9;  // relative tolerance for treating a value as a round number

// The round numbers 1, 2, 5, 10, 20, ... and their fractions, by index.
double RoundNumber(int index) {
  constexpr double kMantissa[] = {1, 2, 5};
  const int decade = index >= 0 ? index / 3 : -((2 - index) / 3);
  return kMantissa[index - 3 * decade] * std::pow(10.0, decade);
}
// Index of the largest round number that is at most `value` > 0.
int RoundIndexBelow(double value) {
  int index = 3 * int(std::floor(std::log10(value))) + 3;
  while (RoundNumber(index) > value * (1 + kSlack)) --index;
  return index;
}
int RoundIndexAbove(double value) {
  const int below = RoundIndexBelow(value);
  return RoundNumber(below) < value * (1 - kSlack) ? below + 1 : below;
}

}  // namespace

ChartScale::ChartScale(std::vector<double> values, bool log, bool from_zero) : log_(log) {
  if (values.empty()) values = {1};
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  low_ = *low;
  high_ = *high;
  if (log_)
    FitLog();
  else
    FitLinear(from_zero);
}

double ChartScale::operator()(double value) const {
  if (log_) return std::log(value / low_) / std::log(high_ / low_);
  return (value - low_) / (high_ - low_);
}

void ChartScale::FitLinear(bool from_zero) {
  constexpr double kIntervals = 6;
  if (low_ >= 0 && (from_zero || low_ < 0.4 * high_)) low_ = 0;
  if (high_ <= low_) high_ = low_ + std::max(1.0, std::abs(low_));
  const double step = RoundNumber(RoundIndexAbove((high_ - low_) / kIntervals));
  low_ = step * std::floor(low_ / step + kSlack);
  high_ = step * std::ceil(high_ / step - kSlack);
  for (int i = 0; low_ + i * step <= high_ + kSlack * step; ++i) ticks_.push_back(low_ + i * step);
}

void ChartScale::FitLog() {
  constexpr int kMaxTicks = 8;
  int first = RoundIndexBelow(low_), last = RoundIndexAbove(high_);
  if (last == first) ++last;
  low_ = RoundNumber(first);
  high_ = RoundNumber(last);
  const bool decades_only = last - first >= kMaxTicks;
  for (int i = first; i <= last; ++i)
    if (!decades_only || i % 3 == 0) ticks_.push_back(RoundNumber(i));
}

std::string ShortNumber(double value, int digits) {
  const char* unit = "";
  if (std::abs(value) >= 1e6)
    value /= 1e6, unit = "M";
  else if (std::abs(value) >= 1e3)
    value /= 1e3, unit = "k";
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, std::abs(value) < 1e-12 ? 0.0 : value);
  return std::string(text) + unit;
}

std::vector<std::string> TickTexts(const std::vector<double>& ticks) {
  constexpr int kAllDigits = 17;  // significant digits of a double
  std::vector<std::string> texts;
  for (int digits = 3; digits <= kAllDigits; ++digits) {
    texts.clear();
    for (const double tick : ticks) texts.push_back(ShortNumber(tick, digits));
    if (std::adjacent_find(texts.begin(), texts.end()) == texts.end()) break;
  }
  return texts;
}

}  // namespace cosplat
