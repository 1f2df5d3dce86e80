#include "apps/charts/svg_chart.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/charts/chart_scale.h"
#include "apps/charts/svg_drawing.h"
#include "apps/charts/svg_legend.h"

namespace cosplat {
namespace {

// px
constexpr double kPlotHeight = 330, kMarginBottom = 54, kMarginLeft = 76;
constexpr double kBar = 17, kGroupGap = 12, kCap = 4;

constexpr const char *kGrid = "#e2e2e2", *kFrame = "#888888", *kRing = "#222222";

std::string Caption(const Axis& axis) {
  return axis.unit.empty() ? axis.name : axis.name + " (" + axis.unit + ")";
}

bool IsShown(const Chart& chart, const Mark& mark) {
  const auto shown = [](double value, const Axis& axis) {
    return std::isfinite(value) && (!axis.log || value > 0);
  };
  return shown(mark.x, chart.x) && (chart.kind == Chart::Kind::kBars || shown(mark.y, chart.y));
}

// Values of all shown marks, including the ends of their error bars.
std::vector<double> Values(const Chart& chart,
                           double Mark::*member,
                           double Mark::*error,
                           bool log) {
  std::vector<double> values;
  for (const auto* all : {&chart.series, &chart.guides})
    for (const ChartSeries& series : *all)
      for (const Mark& mark : series.marks) {
        if (!IsShown(chart, mark)) continue;
        for (const double value :
             {mark.*member, mark.*member - mark.*error, mark.*member + mark.*error})
          if (!log || value > 0) values.push_back(value);
      }
  return values;
}

// Lines and points.
class PointPlot {
 public:
  explicit PointPlot(const Chart& chart)
      : chart_(chart),
        legend_(chart),
        top_(legend_.bottom()),
        bottom_(top_ + kPlotHeight),
        x_scale_(Values(chart, &Mark::x, &Mark::x_error, chart.x.log), chart.x.log, false),
        y_scale_(Values(chart, &Mark::y, &Mark::y_error, chart.y.log), chart.y.log, false),
        drawing_(kChartWidth, bottom_ + kMarginBottom) {}

  std::string Draw() {
    legend_.Draw(chart_.title, drawing_);
    DrawAxes();
    for (const ChartSeries& guide : chart_.guides)
      for (size_t i = 1; i < guide.marks.size(); ++i) DrawGuide(guide.marks[i - 1], guide.marks[i]);
    for (size_t i = 0; i < chart_.series.size(); ++i) DrawSeries(i);
    for (size_t i = 0; i < chart_.series.size(); ++i)
      for (const Mark& mark : chart_.series[i].marks)
        if (IsShown(chart_, mark) && !mark.label.empty()) DrawLabel(mark, ColorOf(i));
    return drawing_.Finish();
  }

 private:
  double X(double value) const { return kMarginLeft + x_scale_(value) * (kRight - kMarginLeft); }
  double Y(double value) const { return bottom_ - y_scale_(value) * kPlotHeight; }

  void DrawAxes() {
    const std::vector<double>&xs = x_scale_.ticks(), &ys = y_scale_.ticks();
    const std::vector<std::string> x_texts = TickTexts(xs), y_texts = TickTexts(ys);
    for (size_t i = 0; i < xs.size(); ++i) {
      drawing_.Line(X(xs[i]), top_, X(xs[i]), bottom_, kGrid);
      drawing_.Text(X(xs[i]), bottom_ + 18, x_texts[i], SvgAnchor::kMiddle);
    }
    for (size_t i = 0; i < ys.size(); ++i) {
      drawing_.Line(kMarginLeft, Y(ys[i]), kRight, Y(ys[i]), kGrid);
      drawing_.Text(kMarginLeft - 8, Y(ys[i]) + 4.5, y_texts[i], SvgAnchor::kEnd);
    }
    drawing_.Line(kMarginLeft, bottom_, kRight, bottom_, kFrame);
    drawing_.Line(kMarginLeft, top_, kMarginLeft, bottom_, kFrame);
    const double middle = 0.5 * (kMarginLeft + kRight);
    drawing_.Text(middle, bottom_ + 42, Caption(chart_.x), SvgAnchor::kMiddle);
    drawing_.UprightText(20, top_ + 0.5 * kPlotHeight, Caption(chart_.y));
  }
  void DrawGuide(const Mark& from, const Mark& to) {
    drawing_.DashedLine(X(from.x), Y(from.y), X(to.x), Y(to.y), kGuideColor);
    TakeLine(X(from.x), Y(from.y), X(to.x), Y(to.y));
  }
  void DrawSeries(size_t index) {
    std::string path;
    const Mark* last = nullptr;
    for (const Mark& mark : chart_.series[index].marks) {
      if (!IsShown(chart_, mark)) continue;
      const double x = X(mark.x), y = Y(mark.y);
      if (!path.empty()) path += ' ';
      path += SvgNumber(x) + "," + SvgNumber(y);
      taken_.push_back({x - 5, y - 5, x + 5, y + 5});
      if (last && chart_.kind == Chart::Kind::kLines) TakeLine(X(last->x), Y(last->y), x, y);
      last = &mark;
    }
    if (chart_.kind == Chart::Kind::kLines) drawing_.Path(path, ColorOf(index));
    for (const Mark& mark : chart_.series[index].marks)
      if (IsShown(chart_, mark)) DrawMark(mark, index);
  }
  void DrawMark(const Mark& mark, size_t series) {
    const double x = X(mark.x), y = Y(mark.y);
    const std::string color = ColorOf(series);
    // On a logarithmic axis, error bars must stay above zero.
    const auto low = [](double value, double error, bool log) {
      return log && error >= value ? value : value - error;
    };
    if (mark.x_error > 0) {
      const double left = X(low(mark.x, mark.x_error, chart_.x.log));
      DrawErrorBar(left, y, X(mark.x + mark.x_error), y, color);
    }
    if (mark.y_error > 0) {
      const double bottom = Y(low(mark.y, mark.y_error, chart_.y.log));
      DrawErrorBar(x, bottom, x, Y(mark.y + mark.y_error), color);
    }
    if (IsHollow(series))
      drawing_.HollowDot(x, y, color);
    else
      drawing_.Dot(x, y, color);
    if (mark.ringed) drawing_.Ring(x, y, kRing);
  }
  // With a cap at both ends.
  void DrawErrorBar(double x0, double y0, double x1, double y1, const std::string& color) {
    const double dx = y0 == y1 ? 0 : kCap, dy = kCap - dx;
    TakeLine(x0, y0, x1, y1);
    drawing_.Line(x0, y0, x1, y1, color);
    drawing_.Line(x0 - dx, y0 - dy, x0 + dx, y0 + dy, color);
    drawing_.Line(x1 - dx, y1 - dy, x1 + dx, y1 + dy, color);
  }
  void TakeLine(double x0, double y0, double x1, double y1) {
    constexpr double kEvery = 6;
    const int steps = 1 + int(std::hypot(x1 - x0, y1 - y0) / kEvery);
    for (int i = 0; i <= steps; ++i) {
      const double x = x0 + (x1 - x0) * i / steps, y = y0 + (y1 - y0) * i / steps;
      taken_.push_back({x - 2, y - 2, x + 2, y + 2});
    }
  }
  // Placed where it covers least: right of the point, left, above or below.
  void DrawLabel(const Mark& mark, const std::string& color) {
    struct LabelPosition {
      double x, y;  // of the text's anchor, on its baseline
      SvgAnchor anchor;
      SvgBox box;
    };
    const double x = X(mark.x), y = Y(mark.y), width = SvgTextWidth(mark.label);
    const double middle = std::clamp(x, kMarginLeft + width / 2, kChartWidth - 4 - width / 2);
    const SvgBox above{middle - width / 2, y - 22, middle + width / 2, y - 8};
    const SvgBox below{above.left, y + 8, above.right, y + 22};
    const std::array<LabelPosition, 4> places{
        LabelPosition{x + 8, y + 4.5, SvgAnchor::kStart, {x + 8, y - 7, x + 8 + width, y + 7}},
        LabelPosition{x - 8, y + 4.5, SvgAnchor::kEnd, {x - 8 - width, y - 7, x - 8, y + 7}},
        LabelPosition{middle, y - 11, SvgAnchor::kMiddle, above},
        LabelPosition{middle, y + 19, SvgAnchor::kMiddle, below}};
    const SvgBox plot{kMarginLeft, top_, kChartWidth - 4, bottom_};
    const auto cost = [&](const LabelPosition& place) {
      double sum = 14 * width - Overlap(place.box, plot);
      for (const SvgBox& other : taken_) sum += Overlap(place.box, other);
      return sum;
    };
    const LabelPosition* best = &places[0];
    for (const LabelPosition& place : places)
      if (cost(place) < cost(*best) - 1e-6) best = &place;
    taken_.push_back(best->box);
    drawing_.Label(best->x, best->y, mark.label, color, best->anchor);
  }

  static constexpr double kRight = kChartWidth - kChartMarginRight;
  const Chart& chart_;
  Legend legend_;
  double top_, bottom_;
  ChartScale x_scale_, y_scale_;
  SvgDrawing drawing_;
  std::vector<SvgBox> taken_;
};

// Bar labels in order of first appearance.
std::vector<std::string> Categories(const Chart& chart) {
  std::vector<std::string> names;
  for (const ChartSeries& series : chart.series)
    for (const Mark& mark : series.marks)
      if (std::find(names.begin(), names.end(), mark.label) == names.end())
        names.push_back(mark.label);
  return names;
}

class BarPlot {
 public:
  explicit BarPlot(const Chart& chart)
      : chart_(chart),
        categories_(Categories(chart)),
        legend_(chart),
        scale_(Values(chart, &Mark::x, &Mark::x_error, chart.x.log), chart.x.log, true),
        top_(legend_.bottom()),
        bars_height_(double(chart.series.size()) * kBar),
        bottom_(top_ + (bars_height_ + kGroupGap) * double(categories_.size())),
        drawing_(kChartWidth, bottom_ + kMarginBottom) {
    for (const std::string& name : categories_) left_ = std::max(left_, 28 + SvgTextWidth(name));
  }

  std::string Draw() {
    legend_.Draw(chart_.title, drawing_);
    for (const double tick : scale_.ticks()) {
      drawing_.Line(X(tick), top_, X(tick), bottom_, kGrid);
      drawing_.Text(X(tick), bottom_ + 18, ShortNumber(tick), SvgAnchor::kMiddle);
    }
    drawing_.Line(left_, top_, left_, bottom_, kFrame);
    drawing_.Text(0.5 * (left_ + kChartWidth), bottom_ + 42, Caption(chart_.x), SvgAnchor::kMiddle);
    for (size_t i = 0; i < categories_.size(); ++i)
      DrawGroup(categories_[i], top_ + (bars_height_ + kGroupGap) * double(i) + kGroupGap / 2);
    return drawing_.Finish();
  }

 private:
  double X(double value) const {
    constexpr double kNumber = 40;  // space for the number after the longest bar
    return left_ + scale_(value) * (kChartWidth - left_ - kChartMarginRight - kNumber);
  }
  void DrawGroup(const std::string& category, double y) {
    drawing_.Text(left_ - 8, y + bars_height_ / 2 + 4.5, category, SvgAnchor::kEnd);
    for (size_t i = 0; i < chart_.series.size(); ++i, y += kBar)
      for (const Mark& mark : chart_.series[i].marks) {
        if (mark.label != category || !IsShown(chart_, mark)) continue;
        if (chart_.x.log) {
          drawing_.Line(left_, y + kBar / 2, X(mark.x), y + kBar / 2, ColorOf(i));
          drawing_.Dot(X(mark.x), y + kBar / 2, ColorOf(i));
        } else {
          drawing_.Rectangle(left_, y + 1, X(mark.x) - left_, kBar - 2, ColorOf(i));
        }
        drawing_.Label(X(mark.x) + 7, y + kBar - 4, ShortNumber(mark.x), "#222222");
      }
  }

  const Chart& chart_;
  std::vector<std::string> categories_;
  Legend legend_;
  ChartScale scale_;
  double top_, bars_height_, bottom_, left_ = 0;
  SvgDrawing drawing_;
};

}  // namespace

std::string ToSvg(const Chart& chart) {
  return chart.kind == Chart::Kind::kBars ? BarPlot(chart).Draw() : PointPlot(chart).Draw();
}

}  // namespace cosplat
