// The runs of a study as one array job of Slurm, for a cluster: each task is
// `cosplat-study --run ID` with a file of lines of its own, which the study's page reads together.
#pragma once

#include <string>
#include <vector>

#include "apps/study/runs/study_runner.h"

namespace cosplat {

struct SlurmJob {
  std::string list;     // the study's list (.json)
  std::string options;  // of sbatch, separated by spaces: "--partition=long --cpus-per-task=8"
};

// Writes <out>/slurm/study.sbatch and submits it by `sbatch`; returns the job's number. Paths are
// made absolute: all nodes must see the same files. A task that is stopped (time limit, requeue)
// leaves a checkpoint, from which it goes on when it is submitted again. Throws Error if sbatch is
// not installed or refuses.
std::string SubmitStudy(const std::vector<StudyRun>& runs,
                        const StudySettings& settings,
                        const SlurmJob& job);

}  // namespace cosplat
