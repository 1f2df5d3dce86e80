// Training steps on the host's processor, on the state's own Gaussians.
#pragma once

#include <memory>
#include <vector>

#include "splat/train/reduced_frames.h"
#include "splat/train/step_engine.h"

namespace cosplat {

class HostStepEngine : public StepEngine {
 public:
  HostStepEngine(const TrainSettings& settings, Subject& subject, TrainingState& state);

  double Step(const StepPlan& plan) override;
  void AfterStep(int iteration) override;
  size_t count() const override { return state_.gaussians.size(); }
  void CatchUp(const AdamSettings& rates) override;
  void ControlDensity(const DensitySettings& settings, bool remove_oversized) override;
  void Prune(const PruneRound& round, int group_cap, int group_floor) override;
  void SortInSpace() override;
  void ResetStatistics() override { state_.statistics.Reset(count()); }
  void ResetOpacity() override;
  void Fetch() override {}
  void FetchForRanking() override {}
  void Store() override { ReleaseScratch(); }
  void SetPruner(Pruner* pruner) override { pruner_ = pruner; }
  std::vector<Contribution> Contributions(const FrameChoice& choice) override;
  double MeanPsnr(const FrameChoice& choice) override;
  PhaseTimes Times() const override;
  std::vector<MemoryPart> Memory() const override;

 private:
  // The step's parts: draw and compare, gradients, parameters.
  double Forward(const StepPlan& plan);
  double Backward(const StepPlan& plan);  // returns what the rule of pruning adds to the loss
  double RegularizeScale();
  void FindGroups();
  void ReleaseScratch();
  // What moves along when Gaussians come and go.
  Population Everyone();

  const TrainSettings& settings_;
  Subject& subject_;
  TrainingState& state_;
  ReducedFrames frames_;
  Pruner* pruner_ = nullptr;
  PhaseTimes times_;
  // Scratch, kept between steps.
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  WorldGaussians world_;  // this step's
  RenderedImage image_;
  PhotometricLoss loss_;
  Buffer<float> d_color_, screen_;
  Gaussians gradients_;
  std::vector<uint32_t> needles_;  // that this step regularises, ascending
  std::vector<uint32_t> groups_;   // that its Adam works on
};

// A StepEngineMaker.
std::unique_ptr<StepEngine> MakeHostStepEngine(const TrainSettings& settings,
                                               Subject& subject,
                                               TrainingState& state);

}  // namespace cosplat
