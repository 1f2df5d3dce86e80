// Training steps on the device: splat/step_engine.h there.
//
// Parameters, moments and statistics live there; a step sends a camera and rates and waits once,
// for the number of instances (cuda::Renderer). Its loss is copied back behind it and read when the
// next step has waited anyway.
#pragma once

#include <memory>

#include "splat/cuda/density.h"
#include "splat/cuda/device_subject.h"
#include "splat/cuda/photographs.h"
#include "splat/cuda/renderer.h"
#include "splat/cuda/step_parts.h"
#include "splat/step_engine.h"

namespace cosplat::cuda {

class DeviceStepEngine : public StepEngine {
 public:
  // Throws Error where the rule of pruning works in every step: those are the host's.
  DeviceStepEngine(const TrainSettings& settings,
                   Subject& subject,
                   TrainingState& state,
                   SumOrder order,
                   std::shared_ptr<DeviceSubject> on_device);

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
  void SetPruner(Pruner*) override {}
  std::vector<Contribution> Contributions(const FrameChoice& choice) override;
  double MeanPsnr(const FrameChoice& choice) override;
  std::string TakeNotice() override { return std::exchange(notice_, {}); }
  PhaseTimes Times() const override { return {}; }
  std::vector<MemoryPart> Memory() const override;

 private:
  // How many Gaussians fit, with what views draw of each at the most so far.
  size_t MostThatFit() const;
  void Draw(const StepPlan& plan);
  void GoBack(const StepPlan& plan);
  void Update(const StepPlan& plan);
  double LastLoss() const;
  // Does it with everything in the host's memory.
  template <class F>
  void OnHost(const F& f);
  cudaStream_t stream() const { return renderer_.stream().get(); }

  const TrainSettings& settings_;
  Subject& subject_;
  TrainingState& state_;
  std::shared_ptr<DeviceSubject> on_device_;
  SumOrder order_;
  Renderer renderer_;
  Population population_;
  Photographs photographs_;
  DensityControl density_;
  NeedleRegularizer needles_;
  PhotometricLoss loss_;
  Tape tape_;
  DeviceImage image_;
  WorldGaussians world_;  // this step's
  DeviceBuffer<float> d_color_, screen_;
  DeviceBuffer<Contribution> of_picture_, contributions_;
  DeviceBuffer<uint8_t> unwanted_;
  Readback<double> photometric_, of_needles_;  // of the last step
  int last_iteration_ = 0;                     // 0: there was none
  double instances_per_gaussian_ = 0;          // the most since the last density control
  bool fetched_ = true;                        // the state is up to date
  bool told_of_memory_ = false;
  std::string notice_;
};

// For Trainer. on_device: null for a static scene.
StepEngineMaker MakeDeviceStepEngine(SumOrder order,
                                     std::shared_ptr<DeviceSubject> on_device = nullptr);

}  // namespace cosplat::cuda
