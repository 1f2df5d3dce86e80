// The page of a study: one self-contained HTML file with its charts, tables and differences.
#pragma once

#include <string>
#include <vector>

#include "apps/charts/svg_chart.h"
#include "apps/study/runs/study_figures.h"

namespace cosplat {

// Writes <folder>/index.html from the lines in the folder; if `charts` is not empty, also writes
// each chart as a file into that folder. Throws Error if there is no line.
// The table of finished models beside published ones is printed, too, if there are any.
void WriteStudyPage(const std::string& folder, const std::string& charts);

// A chart of a study: quality against cost for one data set and one group of settings.
struct StudyChart {
  std::string key;  // "fox-8-pruning-psnr-gaussians": file name
  Chart chart;
};

// One point per setting with the standard errors of both figures. Settings with the same label form
// a curve in order of their counts; Pareto-optimal settings are ringed and joined by a dashed line.
// `points`: of one data set and group.
std::vector<StudyChart> StudyCharts(const std::vector<StudyPoint>& points,
                                    const std::string& group,
                                    const StudyFigure& quality);

}  // namespace cosplat
