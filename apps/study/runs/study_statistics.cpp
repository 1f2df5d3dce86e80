#include "apps/study/runs/study_statistics.h"

#include <algorithm>
#include <cmath>

namespace cosplat {
namespace {

std::optional<double> FigureOf(const StudyLine& line, const std::string& figure, int iterations) {
  for (const StudyFigures& figures : line.checkpoints) {
    const bool wanted = iterations < 0 ? &figures == &line.checkpoints.back()
                                       : figures.at("iterations") == iterations;
    if (wanted && figures.count(figure)) return figures.at(figure);
  }
  return std::nullopt;
}

}  // namespace

Estimate EstimateOf(const std::vector<double>& values) {
  const double n = double(values.size());
  Estimate e;
  e.count = values.size();
  for (const double value : values) e.mean += value / n;
  if (values.size() < 2) return e;
  double squares = 0;
  for (const double value : values) squares += (value - e.mean) * (value - e.mean);
  e.error = std::sqrt(squares / (n - 1) / n);
  return e;
}

std::optional<Estimate> StudyPoint::At(const std::string& figure, int iterations) const {
  std::vector<double> values;
  for (const StudyLine& line : lines)
    if (const auto value = FigureOf(line, figure, iterations)) values.push_back(*value);
  if (values.empty()) return std::nullopt;
  return EstimateOf(values);
}

std::set<int> StudyPoint::Iterations() const {
  std::set<int> all;
  for (const StudyLine& line : lines)
    for (const StudyFigures& figures : line.checkpoints) all.insert(int(figures.at("iterations")));
  return all;
}

std::vector<StudyPoint> PointsOf(const std::vector<StudyLine>& lines) {
  std::vector<StudyPoint> points;
  for (const StudyLine& line : lines) {
    const auto same = [&](const StudyPoint& p) {
      return p.data == line.data && p.name == line.name;
    };
    auto found = std::find_if(points.begin(), points.end(), same);
    if (found == points.end())
      found = points.insert(points.end(), {line.data, line.name, "", {}, {}});
    found->label = line.label;
    found->groups = line.groups;
    found->lines.push_back(line);
  }
  return points;
}

std::optional<Estimate> PairedDifference(const StudyPoint& a,
                                         const StudyPoint& b,
                                         const std::string& figure) {
  std::vector<double> differences;
  for (const StudyLine& of_a : a.lines)
    for (const StudyLine& of_b : b.lines) {
      const auto x = FigureOf(of_a, figure, -1), y = FigureOf(of_b, figure, -1);
      if (of_a.seed == of_b.seed && x && y) differences.push_back(*x - *y);
    }
  if (differences.empty()) return std::nullopt;
  return EstimateOf(differences);
}

std::vector<bool> ParetoFront(const std::vector<CostAndQuality>& points) {
  std::vector<bool> front;
  for (const CostAndQuality& p : points) {
    const auto beats = [&](const CostAndQuality& other) {
      return other.cost <= p.cost && other.quality >= p.quality &&
             (other.cost < p.cost || other.quality > p.quality);
    };
    front.push_back(std::none_of(points.begin(), points.end(), beats));
  }
  return front;
}

}  // namespace cosplat
