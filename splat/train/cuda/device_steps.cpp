// A step of DeviceStepEngine, and what becomes of those that were submitted.
#include <algorithm>

#include "splat/train/cuda/device_memory.h"
#include "splat/train/cuda/device_step_engine.h"

namespace cosplat::cuda {

double DeviceStepEngine::Step(const StepPlan& plan) {
  const Rng rng = state_.rng;
  state_.rng = rng.After(population_.mask.DrawsOf(count()));
  Submit(plan, rng, on_device_->WaitsInSteps() || !forecast_.Knows());
  Settle(last_loss_ ? 1 : 0);
  return *last_loss_;
}

void DeviceStepEngine::Submit(const StepPlan& plan, const Rng& rng, bool waits) {
  Submitted& step = steps_[(oldest_ + in_flight_) % steps_.size()];
  step.plan = plan;
  step.rng = rng;
  step.masked = population_.mask.learns();
  Draw(step, waits);
  Backward(step);
  Update(step);
  step.done.Record(stream());
  ++in_flight_;
  fetched_ = false;
}

void DeviceStepEngine::Settle(size_t left) {
  for (; in_flight_ > left; --in_flight_, oldest_ = (oldest_ + 1) % steps_.size()) {
    const Submitted& step = steps_[oldest_];
    step.done.Wait();
    if (step.counts.Last().instances > step.capacity) {
      Repeat();
      step.done.Wait();
    }
    forecast_.Saw(step.plan.frame, count(), step.counts.Last().instances);
    last_loss_ = LossOf(step);
  }
}

void DeviceStepEngine::Repeat() {
  population_.GoOn(stream());
  population_.adam.step -= uint32_t(in_flight_);
  population_.mask.TakeBack(int64_t(in_flight_));
  const size_t count = std::exchange(in_flight_, 0);
  for (size_t k = 0; k < count; ++k) {
    const Submitted& step = steps_[(oldest_ + k) % steps_.size()];
    Submit(StepPlan(step.plan), Rng(step.rng), true);
  }
}

double DeviceStepEngine::LossOf(const Submitted& step) const {
  double loss = step.photometric.Last();
  CheckLoss(loss, step.plan.iteration);
  if (step.masked) loss += step.of_mask.Last();
  if (settings_.scale_regularizer.weight != 0) loss += step.of_needles.Last();
  return loss;
}

void DeviceStepEngine::Draw(Submitted& step, bool waits) {
  const StepPlan& plan = step.plan;
  TileLists& lists = tape_.lists;
  world_ = on_device_->Place(population_.values, plan.frame, stream());
  if (step.masked) population_.mask.BeforeDraw(population_.values, step.rng, world_, stream());
  const size_t expected = forecast_.Of(plan.frame, count());
  // Where there is no capacity for a guess, what there is may still fit: the host waits to know.
  if (!waits && HasCapacityFor(expected, order_, tape_))
    lists.Expect(expected, population_.overflowed.data());
  const Camera& camera = targets_.CameraOf(plan.frame, plan.downscale);
  renderer_.Forward(world_, state_.gaussians.basis, camera, plan.render, true, image_, tape_);
  step.counts.Ask(lists.counts(), stream());
  step.capacity = lists.capacity();
  instances_per_gaussian_ =
      std::max(instances_per_gaussian_, double(step.capacity) / double(population_.size()));
}

void DeviceStepEngine::Backward(Submitted& step) {
  const StepPlan& plan = step.plan;
  loss_.Evaluate(settings_.loss,
                 image_.color.data(),
                 targets_.Of(plan.frame, plan.downscale, stream()),
                 plan.render.background,
                 d_color_,
                 stream());
  step.photometric.Ask(loss_.value(), stream());
  WorldGradients d_world = on_device_->WorldGradientsFor(population_.gradients, screen_);
  // Adam then reads those of others, too.
  if (settings_.adam_on == AdamOn::kAll || settings_.scale_regularizer.weight != 0)
    d_world.drawn_groups_only = false;
  renderer_.Backward(world_, image_, d_color_.data(), tape_, d_world);
  on_device_->PlaceBackward(population_.values, population_.gradients, stream());
  // Plasticity is of the photometric loss alone: before the regulariser adds to the gradient.
  if (plan.gathers_statistics)
    Accumulate(std::as_const(tape_.radii).view(),
               std::as_const(screen_).view(),
               image_.width,
               image_.height,
               population_,
               stream());
  if (step.masked) LearnMask(step);
}

void DeviceStepEngine::LearnMask(Submitted& step) {
  population_.mask.AfterBackward(population_.values,
                                 std::as_const(tape_.radii).view(),
                                 population_.overflowed.data(),
                                 population_.gradients,
                                 stream());
  step.of_mask.Ask(population_.mask.value(), stream());
}

void DeviceStepEngine::Update(Submitted& step) {
  DeviceView<const float> moves = std::as_const(tape_.radii).view();
  if (settings_.scale_regularizer.weight != 0) {
    needles_.Add(settings_.scale_regularizer, moves, population_, stream());
    step.of_needles.Ask(needles_.value(), stream());
    moves = needles_.moves();
  }
  if (settings_.adam_on == AdamOn::kAll) moves = {};
  population_.adam.Step(step.plan.rates,
                        population_.gradients,
                        moves,
                        on_device_->PositionRateScale(stream()),
                        population_.values,
                        stream());
}

}  // namespace cosplat::cuda
