// Steps that were submitted and are not known to be done.
//
//   Submit -> Settle: waits for a step, and repeats it and those after it if it overflowed
//
// On overflow, the device sets a flag: that step and the next one, which has already been
// submitted, change nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "splat/base/rng.h"
#include "splat/device/buffer.h"
#include "splat/render/rasterizer.h"
#include "splat/train/step/instance_forecast.h"
#include "splat/train/step/step_plan.h"

namespace cosplat {

// A submitted step, and what it reports when it is done.
struct SubmittedStep {
  explicit SubmittedStep(Stream& stream)
      : counts(stream),
        photometric(stream),
        of_mask(stream),
        of_needles(stream),
        done(stream.MakeEvent()) {}
  // The loss of a step that is done; terms that the step does not have are 0. Throws Error if it
  // is not finite.
  double Loss() const;

  StepPlan plan;
  Rng rng;               // before the step's draws
  size_t gaussians = 0;  // that it drew, of all ranks
  size_t capacity = 0;   // for instances
  double of_crop = 0;    // the crop loss
  bool masked = false, regularizes = false;
  Readback<InstanceCounts> counts;
  Readback<double> photometric, of_mask, of_needles;
  std::unique_ptr<StreamEvent> done;
};

// Throws Error, naming the iteration, if the loss is not finite.
void CheckLoss(double loss, int iteration);

class StepsInFlight {
 public:
  // submit: everything of a step. waits: for the number of instances, ruling out overflow.
  using SubmitAll = std::function<void(SubmittedStep& step, bool waits)>;
  // undo: what the host has counted of so many steps.
  using Undo = std::function<void(size_t steps)>;
  StepsInFlight(Stream& stream, const InstanceForecast& forecast, SubmitAll submit, Undo undo);

  void Submit(const StepPlan& plan, const Rng& rng, bool waits);
  // Waits for all submitted steps except the last `left`, and repeats those that overflowed. Throws
  // Error if a loss is not finite.
  void Settle(size_t left);
  // Those in flight belong to another state.
  void Forget();

  const std::optional<double>& last_loss() const { return last_loss_; }  // of a completed step
  const InstanceForecast& forecast() const { return forecast_; }
  uint32_t* overflowed() {
    return overflowed_.data();
  }  // [1] steps change nothing while it is not 0
  // For steps of several views, which are complete when they end.
  SubmittedStep& alone() { return steps_[0]; }

 private:
  void Repeat();

  static constexpr size_t kInFlight = 2;
  Stream& stream_;
  SubmitAll submit_;
  Undo undo_;
  Buffer<uint32_t> overflowed_;
  InstanceForecast forecast_;
  SubmittedStep steps_[kInFlight];  // ring buffer
  size_t oldest_ = 0, in_flight_ = 0;
  std::optional<double> last_loss_;
};

}  // namespace cosplat
