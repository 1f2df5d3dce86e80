// Checkpoints of a run in its folder, and whether a run may start there.
//
// ChooseStart, before data is loaded -> RunCheckpoint, with the data -> RunTraining: reads it when
// resuming, writes it at intervals -> Remove, once the run is finished.
//
// A run goes on if nothing that decides its result has changed: the command, its options, the
// version of the program and the data. Paths may change, as the data's checksums decide; and what
// only says when to save and what to print (kMayChange in run_checkpoint.cpp).
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "apps/cosplat/options/train_options.h"
#include "apps/cosplat/run/data_checksums.h"
#include "splat/base/state_file.h"
#include "splat/train/ranks/ranks.h"

namespace cosplat {

enum class RunStart {
  kNew,       // nothing is there that must be kept
  kResumed,   // goes on from the folder's checkpoint
  kFinished,  // with --resume: the folder holds this run, finished
};

// How a run with these options starts in o.model. `config`: of ConfigOf. On a terminal, asks
// whether to go on with an interrupted run. Throws Error if the folder holds an interrupted or a
// finished run and the options do not say what becomes of it, or do not fit it.
RunStart ChooseStart(const TrainOptions& o, const std::string& config);
// The same on all ranks: rank 0 chooses.
RunStart ChooseStart(const TrainOptions& o, const std::string& config, Ranks& ranks);

// Throws Error if the folder holds an interrupted or a finished run.
void RequireNoRun(const std::string& folder);

class RunCheckpoint {
 public:
  RunCheckpoint(const TrainOptions& o, std::string config, RunStart start, DataChecksums data);

  bool resumes() const { return start_ == RunStart::kResumed; }
  // Returns the iteration that the run had reached. Throws Error if the data has changed, or as
  // StateFile::Read does.
  int Read(const StateDescription& describe) const;
  // Whether the interval has passed since the start or the last checkpoint.
  bool IsDue() const;
  // iteration: that the run has reached, for messages. All of the ranks that share the state call
  // it; the first of them writes, and throws Error as WriteStateFile does; an earlier checkpoint is
  // then still there.
  void Write(int iteration, const StateDescription& describe, const Ranks& ranks);
  // A part of the run's state in a file of its own, without a header. Likewise.
  void WritePart(const std::string& path, const StateDescription& describe, const Ranks& ranks);
  // Writes either, unless no checkpoints are wanted; a failure to write is only a warning: training
  // goes on.
  void Try(const std::function<void()>& write) const;
  // Once everything is written. Throws Error if it cannot be removed, since the run would then be
  // taken for an interrupted one.
  void Remove() const;

 private:
  void WriteTogether(const std::string& path,
                     const std::string& header,
                     const StateDescription& describe,
                     const Ranks& ranks);

  std::string folder_, path_, config_;
  int iterations_;
  std::chrono::duration<double> interval_;
  RunStart start_;
  DataChecksums data_;
  std::chrono::steady_clock::time_point last_;
  bool lost_ = false;  // the last one for what another rank has of the state
};

// What ranks do after a step: they agree in one exchange, on a signal that one of them got (0:
// none) and on the clock of the first of them, which writes.
struct Agreement {
  int signal = 0;
  bool checkpoint = false;
};
Agreement AgreeAfterStep(int signal, const RunCheckpoint& checkpoint, Ranks& ranks);

}  // namespace cosplat
