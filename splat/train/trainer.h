// The training loop: one for static scenes and avatars alike.
//
// frame -> Subject::Place -> Rasterizer -> loss -> back -> Subject::PlaceBackward -> Adam, and
// every so often density control. What a frame is, where the Gaussians are in it and what comes of
// their gradients is the Subject's business: SceneSubject, avatar/train/trainer.h for avatars.
// Where the work is done is the StepEngine's: here is when, in which order and with which numbers.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "splat/prune/pruner.h"
#include "splat/train/bands.h"
#include "splat/train/step_engine.h"
#include "splat/train/subject.h"
#include "splat/train/train_settings.h"

namespace cosplat {

struct StepReport {
  int iteration = 0;
  double loss = 0;  // on a device, of the step before
  size_t gaussians = 0;
  std::string notice;  // to tell whoever watches, in a line; mostly nothing
};

// What a run cost: stats.json.
struct TrainingStatistics {
  int iterations = 0;
  size_t steps = 0;        // more than iterations where the run went back, as for a budget
  double seconds = 0;      // in the training loop: no loading, no evaluation
  double cpu_seconds = 0;  // processor time of all threads, likewise
  size_t gaussians = 0;
  double ms_per_step = 0;  // median of the last 200 steps
  PhaseTimes times;
  size_t ignored_gradients = 0;  // non-finite ones
  DegreeCounts degrees{};
  DegreeFigures bands;
  double drop_psnr = 0;  // dB, changes of training PSNR by dropping bands, all rounds together
};

class Trainer {
 public:
  Trainer(const TrainSettings& settings,
          Subject& subject,
          Gaussians first,
          const StepEngineMaker& make_engine = MakeHostStepEngine);
  Trainer(const Trainer&) = delete;
  Trainer& operator=(const Trainer&) = delete;

  // One iteration. Throws Error when the loss is not finite, the frame's image is not of its
  // camera's size or every Gaussian was pruned.
  StepReport Step();

  // Brings everything here from where it is trained: iteration() and count() do not.
  const TrainingState& state() const;
  int iteration() const { return state_.iteration; }
  size_t count() const { return engine_->count(); }
  // Takes these frames out of what is trained on (an empty list gives all back), and begins a new
  // pass: evidence for choices made during the run (splat/train/budget.h).
  void HoldOut(std::vector<uint32_t> frames);
  // Mean PSNR of these frames as they stand, over the background of training (mid-grey where that
  // is random), images clamped to what bytes can show.
  double PsnrOf(View<const uint32_t> frames);
  // The first step that the rule of pruning has a round after; 0 when there is none.
  int FirstPruneStep() const;
  // A point to go back to, and back. The rule of pruning starts anew with another target: it must
  // be one that keeps nothing between rounds. Times go on: what was tried was paid for.
  struct Checkpoint {
    TrainingState state;
    std::shared_ptr<const SubjectState> subject;
    double drop_psnr;
  };
  Checkpoint Save() const;
  void Restore(const Checkpoint& checkpoint, const PruneSettings& prune);
  // The Gaussians with all that Adam has put off: what to save or judge in the middle of a run. A
  // copy, since making up for it in place would change the run's bits.
  Gaussians CaughtUp() const;
  const TrainSettings& settings() const { return settings_; }
  int active_degree() const;
  size_t frame_count() const { return subject_.frame_count(); }
  TrainingStatistics statistics() const;
  // Everything held between two steps, except what the subject holds.
  std::vector<MemoryPart> Memory() const;

 private:
  size_t NextFrame();
  std::array<float, 3> NextBackground();
  AdamSettings RatesAt(int iteration) const;
  int DownscaleAt(int iteration) const;
  StepPlan PlanOf(int iteration, size_t frame);
  void ControlDensityAt(int iteration);
  PruneRound Rank(int iteration);
  void DropBands();
  bool DropsBandsAt(int iteration) const;
  void CheckSomeAreLeft(int iteration) const;
  std::array<float, 3> MeanBackground() const;
  bool PrunesAt(int iteration) const { return pruner_ && pruner_->PrunesAt(iteration); }
  void MakePrunerFor(const PruneSettings& prune);

  TrainSettings settings_;
  Subject& subject_;
  TrainingState state_;
  std::unique_ptr<Pruner> pruner_;  // null: no rule
  std::vector<uint32_t> frames_;    // that are trained on
  int least_side_ = 0;              // px, of all frames
  std::unique_ptr<StepEngine> engine_;
  // Measurements.
  PhaseTimes times_;  // beside the engine's
  double seconds_ = 0, cpu_seconds_ = 0;
  std::array<double, 200> last_seconds_{};  // of steps, written in turn
  size_t steps_ = 0;
  double drop_psnr_ = 0;
};

}  // namespace cosplat
