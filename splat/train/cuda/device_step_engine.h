// Training steps on the device: splat/train/step_engine.h there.
//
// Parameters, moments and statistics live there; a step sends a camera and rates. The host submits
// all of it and then waits for the step before, whose loss and number of instances it reads, so
// that the device always has something to do. The number of instances is predicted. Where
// there are more, the device halts: that step and the one after it, which was submitted already,
// change nothing, and the host does both again, waiting for the numbers. So a run has the bits of
// one that always knew.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "splat/render/cuda/instance_forecast.h"
#include "splat/render/cuda/renderer.h"
#include "splat/train/cuda/density.h"
#include "splat/train/cuda/device_subject.h"
#include "splat/train/cuda/step_parts.h"
#include "splat/train/cuda/target_images.h"
#include "splat/train/step_engine.h"

namespace cosplat::cuda {

class DeviceStepEngine : public StepEngine {
 public:
  // Throws Error where the rule of pruning works in every step: those are the host's.
  DeviceStepEngine(const TrainSettings& settings,
                   Subject& subject,
                   TrainingState& state,
                   SumOrder order,
                   std::shared_ptr<DeviceSubject> on_device,
                   const InstanceForecast& forecast = InstanceForecast());

  double Step(const StepPlan& plan) override;
  void AfterStep(int iteration) override;
  size_t count() const override { return population_.size(); }
  void CatchUp(const AdamSettings& rates) override;
  // Fewer than the settings' limit where the device's memory would not hold them: TakeNotice.
  void ControlDensity(const DensitySettings& settings, bool remove_oversized) override;
  void Prune(const PruneRound& round, int group_cap, int group_floor) override;
  void SortInSpace() override;
  void ResetStatistics() override;
  void ResetOpacity() override;
  void Fetch() override;
  void FetchForRanking() override;
  void Store() override;
  void SetPruner(Pruner* pruner) override;
  std::vector<Contribution> Contributions(const FrameChoice& choice) override;
  double MeanPsnr(const FrameChoice& choice) override;
  std::string TakeNotice() override { return std::exchange(notice_, {}); }
  PhaseTimes Times() const override { return {}; }
  std::vector<MemoryPart> Memory() const override;

 private:
  // A step that was given to the stream, and what it tells when it is done.
  struct Submitted {
    StepPlan plan;
    Rng rng;              // before what the step draws of it
    size_t capacity = 0;  // for instances
    bool masked = false;
    Readback<TileLists::Counts> counts;
    Readback<double> photometric, of_mask, of_needles;
    Event done;
  };

  // How many Gaussians fit, with what views draw of each at the most so far.
  size_t MostThatFit() const;
  // Gives the stream all of a step. waits: for the number of instances, and it is right for sure.
  void Submit(const StepPlan& plan, const Rng& rng, bool waits);
  void Draw(Submitted& step, bool waits);
  void Backward(Submitted& step);
  void LearnMask(Submitted& step);
  void Update(Submitted& step);
  // Waits for all that was submitted but the last `left` steps, and does again what was in vain.
  // Throws where a loss is not finite.
  void Settle(size_t left);
  // Submits again what is in flight, of which the oldest made the device halt.
  void Repeat();
  double LossOf(const Submitted& step) const;
  void StoreMask();
  // Puts those of `unwanted` that the subject keeps back to 0.
  void HeedVeto(std::vector<uint8_t>& unwanted);
  Canvas SpareCanvas() { return {renderer_, image_, tape_, state_.gaussians.basis}; }
  cudaStream_t stream() const { return renderer_.stream().get(); }

  const TrainSettings& settings_;
  Subject& subject_;
  TrainingState& state_;
  std::shared_ptr<DeviceSubject> on_device_;
  Pruner* pruner_ = nullptr;
  SumOrder order_;
  Renderer renderer_;
  Population population_;
  TargetImages targets_;
  DensityControl density_;
  NeedleRegularizer needles_;
  PhotometricLoss loss_;
  Tape tape_;
  DeviceImage image_;
  WorldGaussians world_;  // this step's
  DeviceBuffer<float> d_color_, screen_;
  DeviceBuffer<Contribution> of_picture_, contributions_;
  DeviceBuffer<uint8_t> unwanted_;
  InstanceForecast forecast_;
  std::array<Submitted, 2> steps_;  // in turn
  size_t oldest_ = 0, in_flight_ = 0;
  std::optional<double> last_loss_;  // of what has settled
  double instances_per_gaussian_ =
      0;                 // that there was capacity for, since the last density control
  bool fetched_ = true;  // the state is up to date
  bool told_of_memory_ = false;
  std::string notice_;
};

// For Trainer. on_device: null for a static scene.
StepEngineMaker MakeDeviceStepEngine(SumOrder order,
                                     std::shared_ptr<DeviceSubject> on_device = nullptr,
                                     const InstanceForecast& forecast = InstanceForecast());

}  // namespace cosplat::cuda
