// Steps of several views, shared by ranks: each draws its own views of the Gaussians of all, and
// updates its own Gaussians.
//
//   for each round of as many views as there are ranks: ViewExchange::Project -> draw the own view
//   -> ViewExchange::Return -> GradientSum;  then Adam on the sums
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "splat/render/phase_times.h"
#include "splat/train/loss/photograph.h"
#include "splat/train/ranks/ranks.h"
#include "splat/train/ranks/shards.h"
#include "splat/train/ranks/view_exchange.h"
#include "splat/train/state/training_state.h"
#include "splat/train/step/gradient_sum.h"
#include "splat/train/step/step_plan.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

// What a view of a step contributes besides gradients of Gaussians.
struct ViewResult {
  double loss = 0;
  Exposure exposure{};  // gradient
};

class ViewBatch {
 public:
  // What is borrowed must outlive this.
  ViewBatch(Subject& subject, Ranks& ranks, StagedRasterizer& rasterizer);

  // Draws a view of the Gaussians that the tape holds.
  using DrawView = std::function<ViewResult(const StepPlan& view)>;
  // Draws views and sums the gradients of own Gaussians in all of them; gathers statistics if the
  // plans say so. Returns what all ranks have of each view.
  std::vector<ViewResult> Run(std::span<const StepPlan> views,
                              TrainingState& state,
                              Drawing& drawing,
                              PhaseTimes& times,
                              const DrawView& draw);
  // Mean over the views of the last Run, and which Gaussians they show.
  GradientSum& sum() { return sum_; }
  // [12] a view's gradient of its exposure, in the stream's memory. Valid until the next call.
  const Buffer<float>& Uploaded(const Exposure& gradient);

  // Since the start, over all ranks, which all call it.
  ExchangeStatistics Exchanged(const Shards& shards, uint64_t assembled) const;
  void Release();
  std::vector<MemoryPart> Memory() const;

 private:
  // What a rank has drawn of a step, exchanged: in the order of the step's views.
  std::vector<ViewResult> ExchangeResults(const std::vector<ViewResult>& own, size_t views);
  void AddPart(const ViewExchange::Part& part,
               bool gathers_statistics,
               TrainingState& state,
               Drawing& drawing,
               PhaseTimes& times);

  Subject& subject_;
  Ranks& ranks_;
  StagedRasterizer& rasterizer_;
  Stream& stream_;
  ViewExchange exchange_;
  GradientSum sum_;
  Buffer<float> exposure_gradient_;
  ExchangeStatistics counted_;
};

}  // namespace cosplat
