// Executes training steps, on the host or on a device.
//
// Trainer decides what happens when and with which parameters: frames, learning rates, degrees,
// rounds. The engine executes it:
//   Subject::ToWorld -> Rasterizer -> StepLoss, crop loss -> Rasterizer::Backward
//   -> Subject::ToWorldBackward -> Adam
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/render/device.h"
#include "splat/render/phase_times.h"
#include "splat/render/rasterizer.h"
#include "splat/train/density/density.h"
#include "splat/train/density/smoothing.h"
#include "splat/train/prune/importance.h"
#include "splat/train/prune/mask_learner.h"
#include "splat/train/prune/pruner.h"
#include "splat/train/ranks/ranks.h"
#include "splat/train/ranks/view_exchange.h"
#include "splat/train/step/frame_loss.h"
#include "splat/train/step/needles.h"
#include "splat/train/step/step_plan.h"
#include "splat/train/step/steps_in_flight.h"
#include "splat/train/step/train_settings.h"
#include "splat/train/step/trained_state.h"
#include "splat/train/step/view_batch.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

// Where steps run: the components of a back end.
struct StepDevice {
  std::unique_ptr<StagedRasterizer> rasterizer;  // its stream is used for everything
  std::unique_ptr<StepLoss> loss;
  std::shared_ptr<Ranks> ranks = OneRank();
  double memory_share = 1;  // of what is free: less where several ranks have one GPU
};
StepDevice HostStepDevice();

// Runs the forward pass, loss, backward pass and update, and adds and removes Gaussians.
//
// On the host, a step is complete when Step returns. With a device, the host submits a whole step
// and then waits for the previous one, whose loss and number of instances it reads, so that the
// device always has work to do. The number of instances is predicted. On overflow, the device sets
// a flag: that step and the next one, which has already been submitted, change nothing, and the
// host repeats both, waiting for the actual numbers. The result is therefore bit-identical to a run
// that always knew them.
class StepEngine : public FrameImages {
 public:
  // Starts from `state`, in host memory: the Gaussians of all ranks, of which it keeps this rank's
  // share, with zero moments. The first three arguments must outlive the engine. Throws Error if
  // the pruning rule works in every step on the host and the steps run on a device, and if a step
  // has several views (settings.batch) and the rule works in every step or learns a mask, the
  // subject moves, or there are more ranks than views.
  StepEngine(const TrainSettings& settings,
             Subject& subject,
             TrainingState& state,
             StepDevice device,
             const InstanceForecast& forecast = InstanceForecast());
  ~StepEngine() override;

  // Executes one step. Returns its loss or, if that would mean waiting for a device, the loss of
  // the previous step. Throws Error if one is not finite.
  //
  // The mean loss of several views (settings.batch), complete when it returns. Their plans differ
  // in frame and background alone; every rank is given the same ones and draws its own. Throws
  // Error, on all ranks, if a loss is not finite.
  double Step(std::span<StepPlan> views);
  // Lets the subject change the Gaussians after a step and its density control.
  void AfterStep(int iteration);

  // Gaussians of all ranks.
  size_t count() const { return state_.count(); }
  Shards& shards() { return state_.shards(); }
  // Same as AdamCatchUpAll; needed before any of what follows.
  void CatchUp(const AdamSettings& rates);
  // Same as those of DensityControl (splat/train/density/density.h). Stays below the settings'
  // limit if the device's memory would not hold that many Gaussians; TakeNotice then reports it.
  void ControlDensity(const DensitySettings& settings, bool remove_oversized);
  size_t Prune(const PruneRound& round, int group_cap, int group_floor);
  void SortInSpace();
  void ResetStatistics();
  void ResetOpacity();
  // Finds the 3D smoothing filter of every Gaussian; the subject must be static.
  void UpdateSmoothing();

  // Brings the state's Gaussians, moments and statistics up to date.
  void Fetch();
  // Those of all ranks, in host memory: what pruning ranks by, without moments and coefficients of
  // bands >= 1. Valid until the next call.
  StateView FetchForRanking();
  // Takes over the state after it was changed.
  void Store();
  // Drops bands (splat/train/density/bands.h). Returns the change of the mean PSNR.
  double DropBands(float threshold,
                   View<const uint32_t> frames,
                   const std::array<float, 3>& background);
  // Sets another pruner; null for none.
  void SetPruner(Pruner* pruner);
  // A copy of the Gaussians of all ranks with Adam's deferred updates applied; the state is
  // unchanged. On rank 0, elsewhere none.
  Gaussians CaughtUp(const AdamSettings& rates);

  std::vector<Contribution> Contributions(const FrameChoice& choice) override;
  ImageError ErrorIn(const FrameChoice& choice) override;
  ImageError ErrorWithout(View<const uint8_t> removed, const FrameChoice& choice) override;
  // The same for these Gaussians, which are in host memory.
  ImageError ErrorOf(const Gaussians& gaussians, const FrameChoice& choice);

  // A message for the user, returned once; usually empty.
  std::string TakeNotice() { return std::exchange(memory_notice_.text, {}); }
  PhaseTimes Times() const;
  // All ranks call it.
  ExchangeStatistics Exchanged() const;
  std::vector<MemoryPart> Memory() const;

 private:
  // That a device's memory limits the Gaussians: told once.
  struct MemoryNotice {
    std::string text;
    bool was_told = false;
  };

  bool on_host() const { return state_.on_host(); }
  // Bytes; not determined on the host.
  double FreeMemory() const { return device_.memory_share * double(stream_.FreeMemory()); }
  void CheckRule(const PruneRule& rule) const;
  void CheckBatch() const;
  Population Everyone();
  void ReleaseScratch();
  void StoreMask();
  // Whether all own gradients in steps of several views are one part (kRowsPerPart), whose memory
  // grows with the Gaussians.
  bool FitsInOnePart() const;
  double OfWhole(size_t numbers) const;
  // How many Gaussians fit in memory, given the most instances per Gaussian so far: of all ranks.
  size_t MaxThatFit();

  // A step of one view: everything of it, submitted to the stream.
  void Submit(SubmittedStep& step, bool waits);
  void Draw(SubmittedStep& step, bool waits);
  void Backward(SubmittedStep& step);
  // The part of both that a view of several has, too.
  void FinishDrawing(SubmittedStep& step);
  void LearnMask(SubmittedStep& step);
  // Where the frame is a guess: its gradients of sizes and opacities.
  void WeakenShapes(Gaussians& gradients);
  // Adds the regularisers' gradients. Returns which Gaussians Adam updates: visible ones, and those
  // that the one of needles acts on.
  View<const float> Regularize(SubmittedStep& step,
                               View<const float> visible,
                               float color_curvature,
                               Gaussians& gradients);
  void Update(const StepPlan& plan, View<const float> updated, const Gaussians& gradients);
  // [12] the frame's exposure; null if none are trained.
  const float* ExposureOf(size_t frame) const;
  void UpdateExposure(const StepPlan& plan, const Buffer<float>& gradient);

  // A step of several views (view_batch.h).
  double StepOfSeveral(std::span<const StepPlan> views);
  ViewResult DrawOwn(const StepPlan& plan);

  const TrainSettings& settings_;
  Subject& subject_;
  StepDevice device_;
  Stream& stream_;
  TrainedState state_;
  FrameLoss loss_;
  NeedleRegularizer needles_;
  MaskLearner mask_;
  StepsInFlight steps_;
  ViewBatch batch_;
  DensityControl density_;
  std::optional<Canvas> canvas_;  // that density control draws on
  SamplingFilter smoothing_;
  Pruner* pruner_ = nullptr;
  Drawing drawing_;
  // Most instances per Gaussian that there was capacity for since the last density control.
  double instances_per_gaussian_ = 0;
  PhaseTimes times_;
  MemoryNotice memory_notice_;
};

using StepEngineMaker = std::function<std::unique_ptr<StepEngine>(
    const TrainSettings& settings, Subject& subject, TrainingState& state)>;
std::unique_ptr<StepEngine> MakeHostStepEngine(const TrainSettings& settings,
                                               Subject& subject,
                                               TrainingState& state);

// Makes the engines that `--device` and `--deterministic` choose (splat/render/device.h), for a
// Trainer of static scenes (avatar/train/avatar_subject.h for avatars). `deterministic`: sums are
// computed in a fixed order, so that repeated runs are bit-identical, as they always are on the
// CPU, and in steps of several views: what ranks do not share must come out alike, on any number of
// them.
StepEngineMaker StepEngineOn(Device device,
                             bool deterministic,
                             const InstanceForecast& forecast = InstanceForecast(),
                             std::shared_ptr<Ranks> ranks = OneRank());
// The same on the host.
StepEngineMaker HostStepEngineOn(std::shared_ptr<Ranks> ranks);

}  // namespace cosplat
