#include <algorithm>
#include <cctype>

#include "apps/study/runs/study_page.h"

namespace cosplat {
namespace {

constexpr double kLogFrom = 4;  // largest to smallest cost from which the axis is logarithmic

struct Placed {
  std::string label;
  double count;
  Mark mark;
};

// In order of their counts; settings without one of the figures are omitted.
std::vector<Placed> PlaceLabels(const std::vector<StudyPoint>& points,
                                const std::string& quality,
                                const std::string& cost) {
  std::vector<Placed> placed;
  for (const StudyPoint& point : points) {
    const auto x = point.At(cost), y = point.At(quality), count = point.At("gaussians");
    if (!x || !y || !count) continue;
    placed.push_back({point.label, count->mean, {x->mean, y->mean, "", x->error, y->error}});
  }
  std::stable_sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    return a.count < b.count;
  });
  return placed;
}

// Rings the Pareto-optimal points and returns them from left to right.
ChartSeries MarkFront(const StudyFigure& quality,
                      const StudyFigure& cost,
                      std::vector<Placed>& placed) {
  std::vector<CostAndQuality> values;
  for (const Placed& p : placed)
    values.push_back({cost.less_is_better ? p.mark.x : -p.mark.x,
                      quality.less_is_better ? -p.mark.y : p.mark.y});
  const std::vector<bool> front = ParetoFront(values);
  ChartSeries line{"Pareto front", {}};
  for (size_t i = 0; i < placed.size(); ++i) {
    placed[i].mark.ringed = front[i];
    if (front[i]) line.marks.push_back({placed[i].mark.x, placed[i].mark.y, ""});
  }
  std::sort(
      line.marks.begin(), line.marks.end(), [](const Mark& a, const Mark& b) { return a.x < b.x; });
  return line;
}

// Curves in order of their settings, each labelled where it has the fewest Gaussians, as curves are
// furthest apart there.
std::vector<ChartSeries> CurvesOf(const std::vector<StudyPoint>& points,
                                  const std::vector<Placed>& placed) {
  std::vector<ChartSeries> curves;
  for (const StudyPoint& point : points) {
    const auto same = [&](const ChartSeries& curve) { return curve.name == point.label; };
    if (std::none_of(curves.begin(), curves.end(), same)) curves.push_back({point.label, {}});
  }
  for (ChartSeries& curve : curves) {
    for (const Placed& p : placed)
      if (p.label == curve.name) curve.marks.push_back(p.mark);
    if (!curve.marks.empty()) curve.marks.front().label = curve.name;
  }
  return curves;
}

bool IsWide(const std::vector<Placed>& placed) {
  double min = placed[0].mark.x, max = min;
  for (const Placed& p : placed) {
    min = std::min(min, p.mark.x);
    max = std::max(max, p.mark.x);
  }
  return min > 0 && max > kLogFrom * min;
}

std::string KeyOf(const std::string& data,
                  const std::string& group,
                  const std::string& quality,
                  const std::string& cost) {
  std::string key = data + "-" + group + "-" + quality + "-" + cost;
  for (char& c : key) c = c == '_' || c == ' ' ? '-' : char(std::tolower(uint8_t(c)));
  return key;
}

}  // namespace

std::vector<StudyChart> StudyCharts(const std::vector<StudyPoint>& points,
                                    const std::string& group,
                                    const StudyFigure& quality) {
  std::vector<StudyChart> charts;
  for (const StudyFigure& cost : CostsIn(points)) {
    std::vector<Placed> placed = PlaceLabels(points, QualityKeyFor(quality, cost), cost.key);
    if (placed.empty()) continue;
    const std::string data = points[0].data;
    Chart chart;
    chart.title = data + ": " + quality.name + " against " + cost.name;
    chart.x = {cost.name, cost.unit, IsWide(placed)};
    chart.y = {quality.name, quality.unit};
    chart.guides = {MarkFront(quality, cost, placed)};
    chart.series = CurvesOf(points, placed);
    charts.push_back({KeyOf(data, group, quality.key, cost.key), std::move(chart)});
  }
  return charts;
}

}  // namespace cosplat
