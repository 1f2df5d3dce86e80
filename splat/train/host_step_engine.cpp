#include "splat/train/host_step_engine.h"

#include <algorithm>
#include <cmath>

#include "splat/base/error.h"

namespace cosplat {

void CheckLoss(double loss, int iteration) {
  if (!std::isfinite(loss))
    throw Error("iteration " + std::to_string(iteration), "the loss is not finite");
}

std::unique_ptr<StepEngine> MakeHostStepEngine(const TrainSettings& settings,
                                               Subject& subject,
                                               TrainingState& state) {
  return std::make_unique<HostStepEngine>(settings, subject, state);
}

HostStepEngine::HostStepEngine(const TrainSettings& settings,
                               Subject& subject,
                               TrainingState& state)
    : settings_(settings),
      subject_(subject),
      state_(state),
      frames_(subject),
      rasterizer_(MakeCpuRasterizer()),
      tape_(rasterizer_->MakeTape()) {}

// Adds the regulariser's gradient; returns its value.
double HostStepEngine::RegularizeScale() {
  const ScaleRegularizer& reg = settings_.scale_regularizer;
  needles_.clear();
  if (reg.weight == 0) return 0;
  const Gaussians& g = state_.gaussians;
  const float limit_log = std::log(reg.limit), ratio_log = std::log(reg.ratio);
  double sum = 0;
  for (size_t i = 0; i < g.size(); ++i) {
    const float* s = g.at(kScaleLog, i);
    const float largest = std::max({s[0], s[1], s[2]});
    if (largest <= limit_log || largest - std::min({s[0], s[1], s[2]}) <= ratio_log) continue;
    needles_.push_back(uint32_t(i));
    sum += std::exp(largest);
  }
  if (needles_.empty()) return 0;
  const double scale = reg.weight / double(needles_.size());
  for (const uint32_t i : needles_) {
    const float* s = g.at(kScaleLog, i);
    const int k = int(std::max_element(s, s + 3) - s);
    gradients_.at(kScaleLog, i)[k] += float(scale) * std::exp(s[k]);
  }
  return sum * scale;
}

// Those with a Gaussian that has a gradient: it was drawn or is regularised.
void HostStepEngine::FindGroups() {
  groups_.clear();
  const size_t n = state_.gaussians.size();
  const View<const float> radii = tape_->radii();
  auto needle = needles_.begin();
  for (size_t g = 0; g < AdamGroupCount(n); ++g) {
    const size_t end = std::min((g + 1) * kGaussianGroup, n);
    bool moves = settings_.adam_on == AdamOn::kAll;
    for (; needle != needles_.end() && *needle < end; ++needle) moves = true;
    for (size_t i = g * kGaussianGroup; i < end && !moves; ++i) moves = radii[i] > 0;
    if (moves) groups_.push_back(uint32_t(g));
  }
}

// What is sized for the Gaussians: while they are copied it need not be there, and afterwards it is
// made anew for as many as there then are.
void HostStepEngine::ReleaseScratch() {
  gradients_ = {};
  screen_ = Buffer<float>();
  groups_ = std::vector<uint32_t>();
  tape_ = rasterizer_->MakeTape();
}

Population HostStepEngine::Everyone() {
  return {subject_, state_.gaussians, state_.adam, state_.statistics, pruner_};
}

double HostStepEngine::Forward(const StepPlan& plan) {
  const TrainFrame& frame = frames_.At(plan.frame, plan.downscale);
  {
    ScopedPhase phase(times_, Phase::kData);
    if (gradients_.size() != state_.gaussians.size()) gradients_ = state_.gaussians.ZerosLike();
  }
  {
    ScopedPhase phase(times_, Phase::kPose);
    world_ = subject_.Place(state_.gaussians, plan.frame);
    if (pruner_) pruner_->BeforeDraw(state_.gaussians, world_, state_.rng);
  }
  rasterizer_->Forward(world_, state_.gaussians.basis, frame.camera, plan.render, image_, *tape_);
  ScopedPhase phase(times_, Phase::kLoss);
  return loss_.Evaluate(
      settings_.loss, image_.color, frame.target, plan.render.background, d_color_);
}

double HostStepEngine::Backward(const StepPlan& plan) {
  WorldGradients d_world = subject_.WorldGradientsFor(gradients_, screen_);
  // Adam then reads those of others, too.
  if (settings_.adam_on == AdamOn::kAll || settings_.scale_regularizer.weight != 0)
    d_world.drawn_groups_only = false;
  rasterizer_->Backward(world_, image_, d_color_, *tape_, d_world);
  {
    ScopedPhase phase(times_, Phase::kPose);
    subject_.PlaceBackward(state_.gaussians, gradients_);
  }
  // Plasticity is of the photometric loss alone: before the regulariser adds to the gradient.
  ScopedPhase phase(times_, Phase::kDensity);
  if (plan.gathers_statistics)
    state_.statistics.Accumulate(*tape_,
                                 screen_,
                                 gradients_.values[kScaleLog],
                                 state_.gaussians.values[kScaleLog],
                                 image_.width,
                                 image_.height);
  if (!pruner_) return 0;
  return pruner_->AfterBackward(state_.gaussians, gradients_, tape_->radii());
}

double HostStepEngine::Step(const StepPlan& plan) {
  double loss = Forward(plan);
  CheckLoss(loss, plan.iteration);
  loss += Backward(plan);
  loss += RegularizeScale();
  ScopedPhase phase(times_, Phase::kAdam);
  FindGroups();
  state_.ignored_gradients += AdamStepAll(
      plan.rates, gradients_, subject_.PositionRateScale(), groups_, state_.gaussians, state_.adam);
  return loss;
}

void HostStepEngine::AfterStep(int iteration) {
  subject_.AfterStep(iteration, state_.gaussians, state_.adam);
}

void HostStepEngine::CatchUp(const AdamSettings& rates) {
  AdamCatchUpAll(rates, subject_.PositionRateScale(), state_.gaussians, state_.adam);
}

void HostStepEngine::ControlDensity(const DensitySettings& settings, bool remove_oversized) {
  ReleaseScratch();
  cosplat::ControlDensity(settings, remove_oversized, Everyone(), state_.rng);
}

void HostStepEngine::Prune(const PruneRound& round, int group_cap, int group_floor) {
  ReleaseScratch();
  Everyone().Prune(round, group_cap, group_floor);
}

void HostStepEngine::SortInSpace() {
  ReleaseScratch();
  cosplat::SortInSpace(Everyone());
}

void HostStepEngine::ResetOpacity() { cosplat::ResetOpacity(state_.gaussians, state_.adam); }

std::vector<Contribution> HostStepEngine::Contributions(const FrameChoice& choice) {
  return ContributionsToFrames(subject_, state_.gaussians, choice);
}

double HostStepEngine::MeanPsnr(const FrameChoice& choice) {
  return MeanPsnrOfFrames(subject_, state_.gaussians, choice);
}

PhaseTimes HostStepEngine::Times() const {
  PhaseTimes times = times_;
  return times += rasterizer_->times;
}

std::vector<MemoryPart> HostStepEngine::Memory() const {
  const DensityStatistics& d = state_.statistics;
  std::vector<MemoryPart> parts{
      {"parameters", HeldBy(state_.gaussians)},
      {"gradients", HeldBy(gradients_)},
      {"first moments", HeldBy(state_.adam.m)},
      {"second moments", HeldBy(state_.adam.v)},
      {"groups of Adam", HeldBy(state_.adam.updated, groups_, needles_)},
      {"density statistics", HeldBy(d.screen_gradient, d.plasticity, d.visible)},
      {"screen gradients", HeldBy(screen_)},
      {"picture and its gradient",
       HeldBy(image_.color, image_.transmittance, d_color_),
       MemoryOf::kPixels},
      {"smaller photographs", frames_.held(), MemoryOf::kPixels}};
  for (MemoryPart& part : tape_->Memory()) parts.push_back(std::move(part));
  return parts;
}

}  // namespace cosplat
