// Shared by all charts of svg_chart.h: dimensions, series colours, title and the legend below it.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "apps/charts/svg_chart.h"
#include "apps/charts/svg_drawing.h"

namespace cosplat {

// px
inline constexpr double kChartWidth = 720, kChartMarginRight = 28, kChartTitleHeight = 34;

// Palette of Okabe & Ito (2008), suitable for colour-blind readers.
inline constexpr std::array<const char*, 7> kSeriesColors{
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#444444"};
inline const char* ColorOf(size_t series) { return kSeriesColors[series % kSeriesColors.size()]; }
// Hollow markers once all colours are used.
inline bool IsHollow(size_t series) { return series / kSeriesColors.size() % 2 == 1; }
inline constexpr const char* kGuideColor = "#777777";

// Names of series and guides in as many rows as they need; empty if there are fewer than two.
class Legend {
 public:
  explicit Legend(const Chart& chart) {
    for (size_t i = 0; i < chart.series.size(); ++i)
      entries_.push_back({0, 0, chart.series[i].name, ColorOf(i), IsHollow(i), false});
    for (const ChartSeries& guide : chart.guides)
      entries_.push_back({0, 0, guide.name, kGuideColor, false, true});
    if (entries_.size() < 2) entries_.clear();
    double x = kLeft, y = kChartTitleHeight + 0.5 * kRow;
    for (Entry& entry : entries_) {
      const double width = kSample + SvgTextWidth(entry.name);
      if (x > kLeft && x + width > kChartWidth - kChartMarginRight) {
        x = kLeft;
        y += kRow;
      }
      entry.x = x;
      entry.y = y;
      x += width + kGap;
    }
  }
  double bottom() const {
    return entries_.empty() ? kChartTitleHeight + 10 : entries_.back().y + kRow;
  }
  void Draw(const std::string& title, SvgDrawing& drawing) const {
    drawing.Title(kLeft, 23, title);
    for (const Entry& e : entries_) {
      if (e.dashed)
        drawing.DashedLine(e.x, e.y, e.x + kSample - 6, e.y, e.color);
      else if (e.hollow)
        drawing.HollowDot(e.x + 9, e.y, e.color);
      else
        drawing.Rectangle(e.x + 4, e.y - 5, 10, 10, e.color);
      drawing.Text(e.x + kSample, e.y + 4.5, e.name);
    }
  }

 private:
  static constexpr double kLeft = 16, kRow = 20, kSample = 20, kGap = 18;
  struct Entry {
    double x, y;
    std::string name;
    const char* color;
    bool hollow, dashed;
  };
  std::vector<Entry> entries_;
};

}  // namespace cosplat
