// What the lines of a study say together: means over seeds, differences paired by seed, and which
// settings no other beats.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/study/runs/study_lines.h"

namespace cosplat {

struct Estimate {
  double mean = 0;
  double error = 0;  // standard error of the mean, s / sqrt(n); 0 where n is 1
  size_t count = 0;  // n
};
// `values`: at least one.
Estimate EstimateOf(const std::vector<double>& values);

// A setting on a data set, its seeds together.
struct StudyPoint {
  std::string data, name;
  // Of the last line: the list may have changed since the first.
  std::string label;
  std::vector<std::string> groups;
  std::vector<StudyLine> lines;  // one per seed
  // Over the seeds that have the figure at the checkpoint; -1: the finished model.
  std::optional<Estimate> At(const std::string& figure, int iterations = -1) const;
  std::set<int> Iterations() const;
};
// In the order of their first lines.
std::vector<StudyPoint> PointsOf(const std::vector<StudyLine>& lines);

// `a` minus `b` over the seeds that both have, finished models.
std::optional<Estimate> PairedDifference(const StudyPoint& a,
                                         const StudyPoint& b,
                                         const std::string& figure);

struct CostAndQuality {
  double cost = 0, quality = 0;
};
// Those of which no other has at most the cost and at least the quality, one of them strictly.
std::vector<bool> ParetoFront(const std::vector<CostAndQuality>& points);

}  // namespace cosplat
