// One run of a study: trained, evaluated and measured, with every step in a child process of its
// own, so that the command in its line reproduces it.
#pragma once

#include <string>

#include "apps/study/runs/study_child.h"
#include "apps/study/runs/study_lines.h"
#include "apps/study/runs/study_list.h"

namespace cosplat {

struct StudySettings {
  std::string data;   // folder of the data sets
  std::string out;    // folder of the study
  std::string lpips;  // folder of an LPIPS network; empty: none
  bool keep = false;  // keep the models
};

// Generates the head that the run's data set is, if it is one and there is none yet.
void PrepareStudyData(const StudyRun& run,
                      const StudySettings& settings,
                      const StudyChildren& children);

// The model stays in <out>/models/<id> until the caller removes it. Throws Error naming the step
// that failed, and StudyStopped.
StudyLine MeasureStudyRun(const StudyRun& run,
                          const StudySettings& settings,
                          const StudyChildren& children);

std::string StudyModelFolder(const StudyRun& run, const StudySettings& settings);

// Rendering speed of a trained model in frames per second of CPU time, on one core, over its
// held-out views. The model is read from its folder, and each frame is rendered completely
// (including posing for an avatar); returns the best of several passes over all views. Reads the
// run's data set. Throws Error if a part of it is missing.
double StudyFramesPerSecond(const std::string& model_folder);

}  // namespace cosplat
