// The charts of a study: on each a data set and a group of settings, a quality against a cost.
#pragma once

#include <string>
#include <vector>

#include "apps/study/charts/svg_chart.h"
#include "apps/study/runs/study_figures.h"

namespace cosplat {

struct StudyChart {
  std::string key;  // "fox-8-pruning-psnr-gaussians": of its file
  Chart chart;
};

// A point per setting with the standard errors of both figures; settings with one label are a
// curve in the order of their counts; those that no other beats are ringed and joined by a dashed
// line. `points`: of one data set and group.
std::vector<StudyChart> StudyCharts(const std::vector<StudyPoint>& points,
                                    const std::string& group,
                                    const StudyFigure& quality);

}  // namespace cosplat
