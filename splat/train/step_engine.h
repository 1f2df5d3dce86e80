// Does the work of a training step, on the host or on a device.
//
// Trainer says what happens when and with which numbers: frames, rates, degrees, rounds; the engine
// does it: Subject::Place -> Rasterizer -> StepLoss -> back -> Subject::PlaceBackward -> Adam.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/prune/pruner.h"
#include "splat/render/device.h"
#include "splat/render/phase_times.h"
#include "splat/render/rasterizer.h"
#include "splat/train/importance.h"
#include "splat/train/instance_forecast.h"
#include "splat/train/kernels/step.h"
#include "splat/train/mask_learner.h"
#include "splat/train/subject.h"
#include "splat/train/target_store.h"
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
};

struct StepPlan {
  int iteration = 0;  // of this step, from 1
  size_t frame = 0;   // of the subject
  RenderSettings render;
  AdamSettings rates;
  bool gathers_statistics = false;  // for density control
  int downscale = 1;                // the sides of its image are divided by this
};

// Where steps are done: the pieces of a back end.
struct StepDevice {
  std::unique_ptr<Rasterizer> rasterizer;  // in whose stream everything is
  std::unique_ptr<StepLoss> loss;
};
StepDevice HostStepDevice();

// Draws, compares, goes back and updates, and adds and removes Gaussians.
//
// On the host every step is done when Step returns. To a device the host submits all of it and then
// waits for the step before, whose loss and number of instances it reads, so that the device always
// has something to do. The number of instances is predicted. Where there are more, the device sets
// a flag: that step and the one after it, which was submitted already, change nothing, and the host
// does both again, waiting for the numbers. So a run has the bits of one that always knew.
class StepEngine : public FrameImages {
 public:
  // Of a run whose state begins as given, in the host's memory; the first three must outlive it.
  // Throws Error where the rule of pruning works in every step on the host and the device is none.
  StepEngine(const TrainSettings& settings,
             Subject& subject,
             TrainingState& state,
             StepDevice device,
             const InstanceForecast& forecast = InstanceForecast());
  ~StepEngine() override;

  // One step. Returns its loss or, where that would mean waiting for a device, the loss of the step
  // before. Throws Error when one is not finite.
  double Step(const StepPlan& plan);
  // What the subject does to the Gaussians after a step and its density control.
  void AfterStep(int iteration);

  size_t count() const { return now_->gaussians.size(); }
  // As AdamCatchUpAll: before any of what follows.
  void CatchUp(const AdamSettings& rates);
  // As DensityControl's (splat/train/density.h). Fewer than the settings' limit where the device's
  // memory would not hold them: TakeNotice.
  void ControlDensity(const DensitySettings& settings, bool remove_oversized);
  void Prune(const PruneRound& round, int group_cap, int group_floor);
  void SortInSpace();
  void ResetStatistics();
  void ResetOpacity();

  // Brings the state's Gaussians, moments and statistics up to date.
  void Fetch();
  // Likewise, but for moments and coefficients of bands 1..: what pruning ranks by.
  void FetchForRanking();
  // Takes the state over after it was changed.
  void Store();
  // Another rule of pruning, or none.
  void SetPruner(Pruner* pruner);
  // The state's Gaussians with all that Adam has put off; the state stays as it is.
  Gaussians CaughtUp(const AdamSettings& rates);

  std::vector<Contribution> Contributions(const FrameChoice& choice) override;
  double MeanPsnr(const FrameChoice& choice) override;
  // The same of these, of the host's memory.
  double MeanPsnrOf(const Gaussians& gaussians, const FrameChoice& choice);

  // What there is to tell whoever watches, once; mostly nothing.
  std::string TakeNotice() { return std::exchange(notice_, {}); }
  PhaseTimes Times() const;
  std::vector<MemoryPart> Memory() const;

 private:
  // A step that was submitted, and what it tells when it is done.
  struct Submitted {
    explicit Submitted(Stream& stream)
        : counts(stream),
          photometric(stream),
          of_mask(stream),
          of_needles(stream),
          done(stream.MakeMoment()) {}
    StepPlan plan;
    Rng rng;              // before what the step draws of it
    size_t capacity = 0;  // for instances
    bool masked = false;
    Readback<InstanceCounts> counts;
    Readback<double> photometric, of_mask, of_needles;
    std::unique_ptr<Moment> done;
  };

  bool on_host() const { return now_ == &state_; }
  Population Everyone();
  void ReleaseScratch();
  void StoreMask();
  // How many Gaussians fit, with what views draw of each at the most so far.
  size_t MostThatFit() const;
  // Gives the stream all of a step. waits: for the number of instances, and it is right for sure.
  void Submit(const StepPlan& plan, const Rng& rng, bool waits);
  void Draw(Submitted& step, bool waits);
  void Backward(Submitted& step);
  void LearnMask(Submitted& step);
  // Adds the gradient of ScaleRegularizer; returns what Adam works on.
  View<const float> RegularizeScale(Submitted& step);
  void Update(Submitted& step);
  // Waits for all that was submitted but the last `left` steps, and does again what was in vain.
  // Throws where a loss is not finite.
  void Settle(size_t left);
  // Submits again what is in flight, of which the oldest had too many instances.
  void Repeat();
  double LossOf(const Submitted& step) const;

  const TrainSettings& settings_;
  Subject& subject_;
  TrainingState& state_;
  StepDevice device_;
  Stream& stream_;
  Pruner* pruner_ = nullptr;
  // What is trained: the state itself on the host, or what a device has of it.
  TrainingState on_device_;
  TrainingState* now_;
  Gaussians gradients_;
  Buffer<uint32_t> overflowed_;  // [1] steps change nothing while it is not 0
  MaskLearner mask_;
  DensityControl density_;
  std::optional<Canvas> canvas_;
  TargetStore targets_;
  PhaseTimes times_;
  // Scratch, kept between steps.
  std::unique_ptr<RenderTape> tape_;
  RenderedImage image_;
  WorldGaussians world_;  // this step's
  Buffer<float> d_color_, screen_;
  Buffer<double> needle_sums_, needle_counts_;  // [blocks]
  Buffer<NeedleTotal> needles_;                 // [1]
  Buffer<float> moves_;
  Buffer<Contribution> of_image_, contributions_;
  InstanceForecast forecast_;
  static constexpr size_t kInFlight = 2;
  Submitted steps_[kInFlight];  // in turn
  size_t oldest_ = 0, in_flight_ = 0;
  std::optional<double> last_loss_;  // of what has settled
  // That there was capacity for, since the last density control.
  double instances_per_gaussian_ = 0;
  bool fetched_ = true;  // the state is up to date
  bool told_of_memory_ = false;
  std::string notice_;
};

using StepEngineMaker = std::function<std::unique_ptr<StepEngine>(
    const TrainSettings& settings, Subject& subject, TrainingState& state)>;
std::unique_ptr<StepEngine> MakeHostStepEngine(const TrainSettings& settings,
                                               Subject& subject,
                                               TrainingState& state);

// Throws Error naming the iteration.
void CheckLoss(double loss, int iteration);

// Where training is done: what `--device` and `--deterministic` choose (splat/render/device.h).

// For Trainer, of static scenes (avatar/train/trainer.h for avatars). `deterministic`: sums in
// a fixed order, so that the same run has the same bits, which on the CPU it always has.
StepEngineMaker StepEngineOn(Device device,
                             bool deterministic,
                             const InstanceForecast& forecast = InstanceForecast());

}  // namespace cosplat
