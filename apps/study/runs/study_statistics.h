// Statistics over the lines of a study: means over seeds, differences paired by seed, and
// Pareto-optimal settings.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/study/runs/study_lines.h"

namespace cosplat {

struct Estimate {
  double mean = 0;
  double error = 0;  // standard error of the mean, s / sqrt(n); 0 if n is 1
  size_t count = 0;  // n
};
// `values`: at least one.
Estimate EstimateOf(const std::vector<double>& values);

// A setting on a data set, over all its seeds.
struct StudyPoint {
  std::string data, name;
  // From the last line, as the list may have changed since the first.
  std::string label;
  std::vector<std::string> groups;
  std::vector<StudyLine> lines;  // one per seed
  // Estimate over the seeds that have the figure at that iteration; -1: the finished model.
  std::optional<Estimate> At(const std::string& figure, int iterations = -1) const;
  std::set<int> Iterations() const;
};
// In order of first appearance.
std::vector<StudyPoint> PointsOf(const std::vector<StudyLine>& lines);

// `a` minus `b`, finished models, over the seeds that both have.
std::optional<Estimate> PairedDifference(const StudyPoint& a,
                                         const StudyPoint& b,
                                         const std::string& figure);

struct CostAndQuality {
  double cost = 0, quality = 0;
};
// True for points such that no other has at most the cost and at least the quality, one of them
// strictly.
std::vector<bool> ParetoFront(const std::vector<CostAndQuality>& points);

}  // namespace cosplat
