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

// How fast a trained model is drawn: frames per second of its held-out views.

// Per second of one core's processor time, of the model as its folder has it, each frame drawn
// whole (an avatar's is posed too); the best of several passes over all held-out views. Reads the
// run's data set. Throws Error when something of it is missing.
double StudyFramesPerSecond(const std::string& model_folder);

}  // namespace cosplat
