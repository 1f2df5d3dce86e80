// One run of a study: trained, evaluated and measured, each step a child process of its own, so
// that the command in its line reproduces it.
#pragma once

#include <string>

#include "apps/study/runs/study_child.h"
#include "apps/study/runs/study_lines.h"
#include "apps/study/runs/study_list.h"

namespace cosplat {

struct StudySettings {
  std::string data;   // folder of the data sets
  std::string out;    // folder of the study
  std::string lpips;  // folder of an LPIPS net; empty: none
  bool keep = false;  // the models
};

// The model is in <out>/models/<id> until the caller removes it. Throws Error naming the step that
// failed, StudyStopped.
StudyLine MeasureStudyRun(const StudyRun& run,
                          const StudySettings& settings,
                          const StudyChildren& children);

std::string StudyModelFolder(const StudyRun& run, const StudySettings& settings);

}  // namespace cosplat
