// Executes training steps, on the host or on a device.
//
// Trainer decides what happens when and with which parameters: frames, learning rates, degrees,
// rounds. The engine executes it:
//   Subject::Place -> Rasterizer -> StepLoss, crop loss -> Rasterizer::Backward
//   -> Subject::PlaceBackward -> Adam
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/math/pinhole.h"
#include "splat/render/device.h"
#include "splat/render/phase_times.h"
#include "splat/render/rasterizer.h"
#include "splat/train/loss/photograph.h"
#include "splat/train/prune/importance.h"
#include "splat/train/prune/mask_learner.h"
#include "splat/train/prune/pruner.h"
#include "splat/train/ranks/all_gaussians.h"
#include "splat/train/ranks/ranks.h"
#include "splat/train/ranks/shards.h"
#include "splat/train/ranks/traffic.h"
#include "splat/train/ranks/view_exchange.h"
#include "splat/train/state/training_state.h"
#include "splat/train/step/gradient_sum.h"
#include "splat/train/step/instance_forecast.h"
#include "splat/train/step/kernels/step.h"
#include "splat/train/step/train_settings.h"
#include "splat/train/subject/subject.h"
#include "splat/train/subject/target_store.h"

namespace cosplat {

// A step of one view, or one view of a step (StepEngine::StepBatch).
struct StepPlan {
  int iteration = 0;  // of this step, from 1
  size_t frame = 0;   // index of the subject's frame
  RenderSettings render;
  AdamSettings rates;
  bool gathers_statistics = false;  // for density control
  int downscale = 1;                // factor that the sides of its image are divided by
  Crop crop;                        // for the crop loss; the engine draws it
  float exposure_rate = 0;          // of Adam on the frame's exposure
};

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
  double Step(const StepPlan& plan);
  // One step of several views, of the mean of their losses; complete when it returns. The plans
  // differ in frame and background alone. Returns the mean loss. Every rank is given the same
  // views, and draws its own. Throws Error, on all ranks, if a loss is not finite.
  double StepBatch(std::vector<StepPlan> views);
  // Lets the subject change the Gaussians after a step and its density control.
  void AfterStep(int iteration);

  // Gaussians of all ranks.
  size_t count() const { return count_; }
  Shards& shards() { return shards_; }
  // Same as AdamCatchUpAll; needed before any of what follows.
  void CatchUp(const AdamSettings& rates);
  // Same as those of DensityControl (splat/train/density/density.h). Stays below the settings'
  // limit if the device's memory would not hold that many Gaussians; TakeNotice then reports it.
  void ControlDensity(const DensitySettings& settings, bool remove_oversized);
  void Prune(const PruneRound& round, int group_cap, int group_floor);
  void SortInSpace();
  void ResetStatistics();
  void ResetOpacity();
  // Finds the 3D smoothing filter of every Gaussian; the subject must be static.
  void UpdateSmoothing();

  // Brings the state's Gaussians, moments and statistics up to date.
  void Fetch();
  // Those of all ranks, in host memory: what pruning ranks by, without moments and coefficients of
  // bands >= 1. Valid until the next call.
  struct Ranked {
    const Gaussians& gaussians;
    const DensityStatistics& statistics;
  };
  Ranked FetchForRanking();
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
  double MeanPsnr(const FrameChoice& choice) override;
  // The same for these Gaussians, which are in host memory.
  double MeanPsnrOf(const Gaussians& gaussians, const FrameChoice& choice);

  // A message for the user, returned once; usually empty.
  std::string TakeNotice() { return std::exchange(notice_, {}); }
  PhaseTimes Times() const;
  // All ranks call it.
  ExchangeStatistics Exchanged() const;
  std::vector<MemoryPart> Memory() const;

 private:
  // A submitted step, and what it reports when it is done.
  struct Submitted {
    explicit Submitted(Stream& stream)
        : counts(stream),
          photometric(stream),
          of_mask(stream),
          of_needles(stream),
          done(stream.MakeMoment()) {}
    StepPlan plan;
    Rng rng;              // before the step's draws
    size_t capacity = 0;  // for instances
    double of_crop = 0;   // the crop loss
    bool masked = false;
    Readback<InstanceCounts> counts;
    Readback<double> photometric, of_mask, of_needles;
    std::unique_ptr<Moment> done;
  };

  // What a view of a step contributes besides gradients of Gaussians.
  struct ViewResult {
    double loss = 0;
    Exposure exposure{};  // gradient
  };

  bool on_host() const { return now_ == &state_; }
  // Bytes; not determined on the host.
  double FreeMemory() const { return device_.memory_share * double(stream_.FreeMemory()); }
  Population Everyone();
  // Before anything that needs the Gaussians of all ranks: assembles them in all_, unless they are
  // there. All ranks do.
  void Assemble(AllGaussians::Extent extent);
  // Takes this rank's share of what density control has changed.
  void TakeOwn();
  // Of all ranks: all_, or what is trained.
  const Gaussians& Shown() const;
  void ReleaseScratch();
  void StoreMask();
  // Of steps of several views: whether all own gradients are one part (kRowsPerPart), whose memory
  // grows with the Gaussians.
  bool FitsInOnePart() const;
  double OfWhole(size_t numbers) const;
  // How many Gaussians fit in memory, given the most instances per Gaussian so far: of all ranks.
  size_t MostThatFit();
  // Submits all of a step to the stream. waits: for the number of instances, ruling out overflow.
  void Submit(const StepPlan& plan, const Rng& rng, bool waits);
  void Draw(Submitted& step, bool waits);
  // The part of it after the rasteriser has drawn the Gaussians.
  void FinishDrawing(Submitted& step);
  RenderSettings RenderOf(const StepPlan& plan);
  // Loss of what was drawn, and its gradient with respect to the image.
  void Evaluate(Submitted& step);
  void Backward(Submitted& step);
  void CheckBatch() const;
  // Views [first, first + ranks) of a step: draws the one that is this rank's and adds up the
  // gradients of its own Gaussians in all.
  void RunRound(const std::vector<StepPlan>& views,
                size_t first,
                Submitted& step,
                std::vector<ViewResult>& own);
  ViewResult DrawOwn(Submitted& step, const StepPlan& plan);
  // What all ranks have of a step, in the order of its views.
  std::vector<ViewResult> ExchangeResults(const std::vector<ViewResult>& own, size_t views);
  // The frame's exposure; null if none are trained.
  const float* ExposureOf(size_t frame) const;
  // Adam on the exposures of a step's views, which all ranks have drawn together.
  void UpdateExposures(const std::vector<StepPlan>& views, const std::vector<ViewResult>& results);
  // Adds the crop loss and its gradient to those of the photometric loss. shown: what is compared.
  // Waits for a device.
  void AddCropLoss(Submitted& step, const Buffer<float>& shown);
  void LearnMask(Submitted& step);
  // Sums of needles, over all ranks, as SumInTree gives them.
  View<const NeedleSum> SumNeedles(const NeedleRule& rule);
  // Adds the gradient of ScaleRegularizer; returns which Gaussians Adam updates: visible ones, and
  // those that it acts on. visible: [own] positive if so.
  View<const float> RegularizeScale(Submitted& step,
                                    View<const float> visible,
                                    Gaussians& gradients);
  void Update(const StepPlan& plan, View<const float> moves, const Gaussians& gradients);
  // Waits for all submitted steps except the last `left`, and repeats those that overflowed. Throws
  // Error if a loss is not finite.
  void Settle(size_t left);
  // Resubmits the steps in flight after the oldest of them overflowed.
  void Repeat();
  double LossOf(const Submitted& step) const;

  const TrainSettings& settings_;
  Subject& subject_;
  TrainingState& state_;
  StepDevice device_;
  Stream& stream_;
  Pruner* pruner_ = nullptr;
  // What is trained: the state itself on the host, or its copy on a device.
  TrainingState on_device_;
  TrainingState* now_;
  Gaussians gradients_;          // of several views, of a part of the Gaussians at a time
  size_t count_ = 0;             // of all ranks
  Buffer<uint32_t> overflowed_;  // [1] steps change nothing while it is not 0
  MaskLearner mask_;
  DensityControl density_;
  std::optional<Canvas> canvas_;
  TargetStore targets_;
  PhaseTimes times_;
  Shards shards_;
  ViewExchange exchange_;
  AllGaussians all_;
  GradientSum sum_;
  // Of all ranks, on the host, where they are trained on a device.
  Gaussians ranked_;
  DensityStatistics ranked_statistics_;
  ExchangeStatistics exchanged_;
  // Scratch, reused between steps.
  std::unique_ptr<RenderTape> tape_;
  RenderedImage image_;
  WorldGaussians world_;  // this step's
  LayerModel layers_;
  PhotographModel photograph_;
  Buffer<float> exposure_gradient_;  // of one view, of several
  Buffer<float> d_color_, screen_;
  Buffer<float> crop_, rendered_crop_, target_crop_;  // the last two in host memory
  std::vector<float> d_crop_;
  Buffer<NeedleSum> needle_sums_, all_needle_sums_;  // of SumInTree
  Buffer<NeedleTotal> needles_;                      // [1]
  Buffer<float> moves_;
  Buffer<math::Pinhole<float>> sampling_views_;  // [frames] once UpdateSmoothing was called
  Buffer<Contribution> of_image_, contributions_;
  InstanceForecast forecast_;
  static constexpr size_t kInFlight = 2;
  Submitted steps_[kInFlight];  // ring buffer
  size_t oldest_ = 0, in_flight_ = 0;
  std::optional<double> last_loss_;  // of the last completed step
  // Most instances per Gaussian that there was capacity for since the last density control.
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

// Throws Error, naming the iteration, if the loss is not finite.
void CheckLoss(double loss, int iteration);

// Makes the engines that `--device` and `--deterministic` choose (splat/render/device.h), for a
// Trainer of static scenes (avatar/train/trainer.h for avatars). `deterministic`: sums are computed
// in a fixed order, so that repeated runs are bit-identical, as they always are on the CPU, and in
// steps of several views: what ranks do not share must come out alike, on any number of them.
StepEngineMaker StepEngineOn(Device device,
                             bool deterministic,
                             const InstanceForecast& forecast = InstanceForecast(),
                             std::shared_ptr<Ranks> ranks = OneRank());
// The same on the host.
StepEngineMaker HostStepEngineOn(std::shared_ptr<Ranks> ranks);

}  // namespace cosplat
