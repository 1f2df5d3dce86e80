// Who does the work of a training step, where the Gaussians are kept: HostStepEngine in the host's
// memory, splat/*/cuda/ on a device.
//
// Trainer says what happens when and with which numbers: frames, rates, degrees, rounds. An engine
// draws, compares, goes back and updates, and adds and removes Gaussians.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "splat/device/memory_part.h"
#include "splat/prune/pruner.h"
#include "splat/render/phase_times.h"
#include "splat/render/rasterizer.h"
#include "splat/train/importance.h"
#include "splat/train/subject.h"
#include "splat/train/train_settings.h"

namespace cosplat {

// Everything that a run is at a moment, beside its subject's own state (AvatarTrainingState) and
// what a rule of pruning learns: writing and reading it makes an exact checkpoint. Until the last
// iteration, `adam` may have put off something for Gaussians that were not drawn lately.
struct TrainingState {
  Gaussians gaussians;
  AdamState adam;
  DensityStatistics statistics;
  Rng rng;
  int iteration = 0;
  std::vector<uint32_t> frames_left;  // of the current pass, in the order they will be popped
  size_t ignored_gradients = 0;       // non-finite ones, so far
};

struct StepPlan {
  int iteration = 0;  // of this step, from 1
  size_t frame = 0;   // of the subject
  RenderSettings render;
  AdamSettings rates;
  bool gathers_statistics = false;  // for density control
  int downscale = 1;                // the sides of its picture are divided by this
};

class StepEngine : public FramePictures {
 public:
  // One step. Returns its loss or, where that would mean waiting for a device, the loss of the step
  // before. Throws Error when one is not finite.
  virtual double Step(const StepPlan& plan) = 0;
  // What the subject does to the Gaussians after a step and its density control.
  virtual void AfterStep(int iteration) = 0;

  virtual size_t count() const = 0;
  // As AdamCatchUpAll: before any of what follows.
  virtual void CatchUp(const AdamSettings& rates) = 0;
  // As ControlDensity, Population::Prune and SortInSpace (splat/train/density.h).
  virtual void ControlDensity(const DensitySettings& settings, bool remove_oversized) = 0;
  virtual void Prune(const PruneRound& round, int group_cap, int group_floor) = 0;
  virtual void SortInSpace() = 0;
  virtual void ResetStatistics() = 0;
  virtual void ResetOpacity() = 0;

  // Brings the state's Gaussians, moments, statistics and ignored gradients up to date.
  virtual void Fetch() = 0;
  // Likewise, but for moments and coefficients of bands 1..: what pruning ranks by.
  virtual void FetchForRanking() = 0;
  // Takes the state over after it was changed.
  virtual void Store() = 0;
  // Another rule of pruning, or none.
  virtual void SetPruner(Pruner* pruner) = 0;

  // What there is to tell whoever watches, once; mostly nothing.
  virtual std::string TakeNotice() { return {}; }
  virtual PhaseTimes Times() const = 0;
  virtual std::vector<MemoryPart> Memory() const = 0;
};

// Of a run whose state begins as given. All three must outlive it.
using StepEngineMaker = std::function<std::unique_ptr<StepEngine>(
    const TrainSettings& settings, Subject& subject, TrainingState& state)>;

// Throws Error naming the iteration.
void CheckLoss(double loss, int iteration);

}  // namespace cosplat
