// The training loop, shared by static scenes and avatars.
//
// frame -> Subject::ToWorld -> Rasterizer -> loss -> Rasterizer::Backward ->
// Subject::ToWorldBackward
// -> Adam, with density control at intervals. The Subject (SceneSubject, or
// avatar/train/avatar_subject.h for avatars) defines the frames, where the Gaussians are in them
// and what becomes of their gradients. The StepEngine determines where the work is done; Trainer
// determines when, in which order and with which parameters.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "splat/train/density/bands.h"
#include "splat/train/prune/pruner.h"
#include "splat/train/step/step_engine.h"
#include "splat/train/step/train_settings.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

struct StepReport {
  int iteration = 0;
  double loss = 0;  // on a device, of the previous step
  size_t gaussians = 0;
  std::string notice;  // a line for the user; usually empty
};

// Cost of a run, as written to stats.json.
struct TrainingStatistics {
  int iterations = 0;
  size_t steps = 0;        // fewer than iterations with several views per step
  double seconds = 0;      // in the training loop: no loading, no evaluation
  double cpu_seconds = 0;  // CPU time of all threads, likewise
  size_t gaussians = 0;
  double ms_per_step = 0;  // median of the last 200 steps
  PhaseTimes times;
  size_t ignored_gradients = 0;  // non-finite ones
  DegreeCounts degrees{};
  DegreeFigures bands;
  size_t pruned = 0;     // Gaussians that the rule and the cap per group removed
  double drop_psnr = 0;  // dB, change of training PSNR from dropping bands, sum of all rounds
  ExchangeStatistics exchanged;
};

class Trainer {
 public:
  Trainer(const TrainSettings& settings,
          Subject& subject,
          Gaussians first,
          const StepEngineMaker& make_engine = MakeHostStepEngine);
  Trainer(const Trainer&) = delete;
  Trainer& operator=(const Trainer&) = delete;

  // One step. Throws Error if the loss is not finite, the frame's image does not have its
  // camera's size or every Gaussian was pruned.
  // A step covers as many iterations as it has views: TrainSettings::batch, fewer at the end.
  StepReport Step();

  // Fetches everything from where it is trained; iteration() and count() do not. Of several ranks,
  // each has its own Gaussians.
  const TrainingState& state() const;
  int iteration() const { return state_.iteration; }
  size_t count() const { return engine_->count(); }
  // Goes on with the exposures of all frames that an earlier training found
  // (TrainSettings::exposure).
  void SetExposures(ExposureState exposures);
  // Excludes these frames from training (an empty list restores all) and begins a new pass. Used to
  // judge what is trained.
  void HoldOut(std::vector<uint32_t> frames);
  // For one rank only. Mean PSNR of these frames with the current Gaussians, over the background of
  // training (mid-grey if that is random), with images clamped to [0, 1].
  double PsnrOf(View<const uint32_t> frames);
  // Writes all that this run is to a checkpoint, or reads it: the same steps follow, bit for bit,
  // with any number of threads. Settings and data must be those that it was written with, and are
  // not in it. Throws Error if what is read does not fit them; the trainer is then not to be used.
  // Of several ranks all call it (splat/train/serialize_state.h).
  void Serialize(StateArchive& archive);
  // The Gaussians with Adam's deferred updates applied and the 3D smoothing filter baked in, to
  // save or evaluate in the middle of a run. A copy, since catching up in place would change the
  // results of the run. All ranks call it; rank 0 has them, the others none.
  Gaussians CaughtUp() const;
  // The Gaussians as they are at the end of the run, on rank 0: nothing but state().exposures may
  // be asked for afterwards.
  Gaussians TakeGaussians();
  const TrainSettings& settings() const { return settings_; }
  int active_degree() const;
  size_t frame_count() const { return subject_.frame_count(); }
  // All ranks call it.
  TrainingStatistics statistics() const;
  // Everything held between two steps, except the subject's data in host memory.
  std::vector<MemoryPart> Memory() const;

 private:
  size_t NextFrame();
  std::array<float, 3> NextBackground();
  AdamSettings RatesAt(int iteration) const;
  // Iterations after the step that begins after this one.
  int EndOfStep(int begin) const;
  // Those of the last step; before the first, of that.
  AdamSettings LastRates() const;
  int DownscaleAt(int iteration) const;
  void UpdateSmoothing();
  StepPlan PlanOf(int iteration, size_t frame);
  StepPlan NextView(int iteration);
  double Train(int begin, int end);
  void ControlDensityAt(int iteration);
  PruneRound Rank(int iteration);
  void DropBands();
  bool DropsBandsAt(int iteration) const;
  void CheckCropLoss() const;
  void CheckSomeAreLeft(int iteration) const;
  std::array<float, 3> MeanBackground() const;
  bool PrunesAt(int iteration) const { return pruner_ && pruner_->PrunesAt(iteration); }
  void MakePrunerFor(size_t gaussians);

  TrainSettings settings_;
  Subject& subject_;
  TrainingState state_;
  std::unique_ptr<Pruner> pruner_;  // null: no rule
  std::vector<uint32_t> frames_;    // frames that are trained on
  int min_side_ = 0;                // px, of all frames
  std::vector<StepPlan> views_;     // of the step
  std::unique_ptr<StepEngine> engine_;
  // Measurements.
  PhaseTimes times_;  // besides the engine's
  double seconds_ = 0, cpu_seconds_ = 0;
  std::array<double, 200> last_seconds_{};  // of steps, a ring buffer
  size_t steps_ = 0;
  double drop_psnr_ = 0;
  uint64_t pruned_ = 0;
};

}  // namespace cosplat
