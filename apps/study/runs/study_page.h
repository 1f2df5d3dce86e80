// The page of a study: one self-contained HTML file with its charts, tables and differences.
#pragma once

#include <string>
#include <vector>

#include "apps/study/charts/svg_chart.h"
#include "apps/study/runs/study_figures.h"

namespace cosplat {

// Writes <folder>/index.html from the lines in it; with `charts`, each chart as a file of that
// folder, too. Throws Error when there is no line.
void WriteStudyPage(const std::string& folder, const std::string& charts);

// The charts of a study: on each a data set and a group of settings, a quality against a cost.

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
