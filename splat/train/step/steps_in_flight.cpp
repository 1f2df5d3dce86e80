#include "splat/train/step/steps_in_flight.h"

#include <cmath>
#include <string>

#include "splat/base/error.h"

namespace cosplat {

void CheckLoss(double loss, int iteration) {
  if (!std::isfinite(loss))
    throw Error("iteration " + std::to_string(iteration), "the loss is not finite");
}

double SubmittedStep::Loss() const {
  double loss = photometric.Last() + of_crop;
  CheckLoss(loss, plan.iteration);
  if (masked) loss += of_mask.Last();
  if (regularizes) loss += of_needles.Last();
  return loss;
}

StepsInFlight::StepsInFlight(Stream& stream,
                             const InstanceForecast& forecast,
                             SubmitAll submit,
                             Undo undo)
    : stream_(stream),
      submit_(std::move(submit)),
      undo_(std::move(undo)),
      forecast_(forecast),
      steps_{SubmittedStep(stream), SubmittedStep(stream)} {}

void StepsInFlight::Submit(const StepPlan& plan, const Rng& rng, bool waits) {
  SubmittedStep& step = steps_[(oldest_ + in_flight_) % kInFlight];
  step.plan = plan;
  step.rng = rng;
  submit_(step, waits);
  step.done->Record();
  ++in_flight_;
}

void StepsInFlight::Settle(size_t left) {
  for (; in_flight_ > left; --in_flight_, oldest_ = (oldest_ + 1) % kInFlight) {
    const SubmittedStep& step = steps_[oldest_];
    step.done->Wait();
    if (step.counts.Last().instances > step.capacity) {
      Repeat();
      step.done->Wait();
    }
    if (!stream_.on_host())
      forecast_.Saw(step.plan.frame, step.gaussians, step.counts.Last().instances);
    last_loss_ = step.Loss();
  }
}

void StepsInFlight::Repeat() {
  overflowed_.FillWithZeros(stream_);
  undo_(in_flight_);
  const size_t count = std::exchange(in_flight_, 0);
  for (size_t k = 0; k < count; ++k) {
    const SubmittedStep& step = steps_[(oldest_ + k) % kInFlight];
    Submit(StepPlan(step.plan), Rng(step.rng), true);
  }
}

void StepsInFlight::Forget() {
  in_flight_ = 0;
  overflowed_.Refill(1, stream_);
  overflowed_.FillWithZeros(stream_);
}

}  // namespace cosplat
