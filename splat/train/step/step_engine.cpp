#include "splat/train/step/step_engine.h"

#include <algorithm>
#include <utility>

#include "splat/base/error.h"
#include "splat/basis_constants.h"
#include "splat/device/for_each.h"
#include "splat/train/step/kernels/step.h"
#include "splat/train/subject/reduced_frames.h"

namespace cosplat {
namespace {

constexpr double kTargetShare = 0.25;  // of the initially free memory
// A guess knows colours and places better than extents, which frames from other sides know
// (docs/tried.md).
constexpr float kShapeShareOfGuess = 0.3f;

size_t TargetBytes(const Stream& stream, double share) {
  return stream.on_host() ? 0 : size_t(kTargetShare * share * double(stream.FreeMemory()));
}

}  // namespace

StepDevice HostStepDevice() { return {MakeCpuRasterizer(), std::make_unique<PhotometricLoss>()}; }

std::unique_ptr<StepEngine> MakeHostStepEngine(const TrainSettings& settings,
                                               Subject& subject,
                                               TrainingState& state) {
  return HostStepEngineOn(OneRank())(settings, subject, state);
}

StepEngineMaker HostStepEngineOn(std::shared_ptr<Ranks> ranks) {
  return [ranks](const TrainSettings& settings, Subject& subject, TrainingState& state) {
    StepDevice device = HostStepDevice();
    device.ranks = ranks;
    return std::make_unique<StepEngine>(settings, subject, state, std::move(device));
  };
}

StepEngine::StepEngine(const TrainSettings& settings,
                       Subject& subject,
                       TrainingState& state,
                       StepDevice device,
                       const InstanceForecast& forecast)
    : settings_(settings),
      subject_(subject),
      device_(std::move(device)),
      stream_(device_.rasterizer->stream()),
      state_(state, *device_.ranks, stream_),
      loss_(settings, subject, *device_.loss, stream_, TargetBytes(stream_, device_.memory_share)),
      needles_(settings.scale_regularizer, stream_),
      steps_(
          stream_,
          forecast,
          [this](SubmittedStep& step, bool waits) { Submit(step, waits); },
          [this](size_t steps) {
            state_.Write().adam.step -= uint32_t(steps);
            mask_.TakeBack(int64_t(steps));
          }),
      batch_(subject, *device_.ranks, *device_.rasterizer) {
  CheckRule(FindPruneRule(settings.prune.rule));
  CheckBatch();
  drawing_.tape = device_.rasterizer->MakeTape();
  subject_.WorkIn(stream_);
  try {
    Store();
  } catch (const std::exception&) {
    subject_.WorkIn(HostStream());  // this engine's stream is about to be destroyed
    throw;
  }
}

void StepEngine::CheckRule(const PruneRule& rule) const {
  if (rule.on_host && !on_host())
    throw Error("--prune " + rule.name,
                "runs on the CPU in every step: use --device cpu or another rule");
  if ((rule.on_host || rule.learns_mask) && settings_.batch > 1)
    throw Error("--prune " + rule.name,
                "works in steps of one view: use --batch 1 or another rule");
}

void StepEngine::CheckBatch() const {
  const std::string option = "--batch " + std::to_string(settings_.batch);
  if (device_.ranks->size() > size_t(settings_.batch))
    throw Error(option,
                "has fewer views than the " + std::to_string(device_.ranks->size()) +
                    " ranks that would share them");
  if (settings_.batch > 1 && !subject_.is_static())
    throw Error(option, "needs a scene that does not move");
}

StepEngine::~StepEngine() {
  try {
    stream_.Wait();  // steps in flight use what is destroyed now
    subject_.WorkIn(HostStream());
  } catch (const std::exception&) {
    // The error was reported by the call that waited first.
  }
}

void StepEngine::StoreMask() { mask_.Upload(pruner_ ? pruner_->Mask() : MaskInSteps(), stream_); }

void StepEngine::SetPruner(Pruner* pruner) {
  pruner_ = pruner;
  StoreMask();
}

void StepEngine::Store() {
  state_.Store();
  ReleaseScratch();
  if (settings_.batch == 1) drawing_.gradients.RefillLike(state_.now().gaussians, stream_);
  steps_.Forget();
  StoreMask();
  stream_.Wait();
}

void StepEngine::Fetch() {
  steps_.Settle(0);
  state_.Read(Where::kHost, Extent::kOwn);
  mask_.Download(stream_);
}

void StepEngine::AfterStep(int iteration) {
  if (!subject_.ChangesAfter(iteration)) return;
  steps_.Settle(0);
  TrainingState& state = state_.Write();
  subject_.Change(iteration, state.gaussians, state.adam);
}

double StepEngine::Step(std::span<StepPlan> views) {
  Rng& rng = state_.host().rng;
  if (loss_.has_crop())
    for (StepPlan& view : views) view.crop = loss_.ChooseCrop(view, rng);
  if (settings_.batch > 1) return StepOfSeveral(views);
  const Rng before = rng;
  rng = before.After(mask_.DrawsOf(count()));
  const bool waits =
      on_host() || subject_.WaitsInSteps() || loss_.has_crop() || !steps_.forecast().Knows();
  steps_.Submit(views.front(), before, waits);
  steps_.Settle(!on_host() && steps_.last_loss() ? 1 : 0);
  return *steps_.last_loss();
}

void StepEngine::Submit(SubmittedStep& step, bool waits) {
  step.gaussians = count();
  step.masked = mask_.learns();
  step.regularizes = needles_.acts();
  Draw(step, waits);
  Backward(step);
  Gaussians& gradients = drawing_.gradients;
  if (subject_.IsGuess(step.plan.frame)) WeakenShapes(gradients);
  const View<const float> updated =
      Regularize(step, drawing_.tape->radii(), step.plan.color_curvature, gradients);
  Update(step.plan, settings_.adam_on == AdamOn::kAll ? View<const float>() : updated, gradients);
  if (settings_.exposure) UpdateExposure(step.plan, loss_.d_exposure());
}

void StepEngine::Draw(SubmittedStep& step, bool waits) {
  const StepPlan& plan = step.plan;
  const Gaussians& gaussians = state_.now().gaussians;
  {
    ScopedPhase phase(times_, Phase::kData);
    if (drawing_.gradients.size() != count()) drawing_.gradients.RefillLike(gaussians, stream_);
  }
  {
    ScopedPhase phase(times_, Phase::kPose);
    drawing_.world = subject_.ToWorld(gaussians, plan.frame);
    if (step.masked) mask_.BeforeDraw(gaussians, step.rng, drawing_.world, stream_);
  }
  if (!waits) drawing_.tape->Expect(steps_.forecast().Of(plan.frame, count()), steps_.overflowed());
  device_.rasterizer->Forward(drawing_.world,
                              gaussians.basis,
                              Reduced(subject_.camera(plan.frame), plan.downscale),
                              loss_.RenderOf(plan),
                              drawing_.image,
                              *drawing_.tape);
  FinishDrawing(step);
}

void StepEngine::FinishDrawing(SubmittedStep& step) {
  loss_.AddBehind(step.plan, drawing_.image);
  step.counts.Ask(drawing_.tape->counts(), stream_);
  step.capacity = drawing_.tape->capacity();
  instances_per_gaussian_ =
      std::max(instances_per_gaussian_, double(step.capacity) / double(count()));
}

void StepEngine::Backward(SubmittedStep& step) {
  {
    ScopedPhase phase(times_, Phase::kLoss);
    loss_.Evaluate(ExposureOf(step.plan.frame), drawing_.image, step);
  }
  // On the host nothing has changed yet.
  if (on_host()) CheckLoss(step.photometric.Last() + step.of_crop, step.plan.iteration);
  TrainingState& state = state_.Write();
  Gaussians& gradients = drawing_.gradients;
  WorldGradients d_world = subject_.WorldGradientsFor(gradients, drawing_.screen, stream_);
  // Adam then also reads the gradients of other groups.
  if (settings_.adam_on == AdamOn::kAll || needles_.acts()) d_world.drawn_groups_only = false;
  device_.rasterizer->Backward(
      drawing_.world, drawing_.image, loss_.d_color(), *drawing_.tape, d_world);
  {
    ScopedPhase phase(times_, Phase::kPose);
    subject_.ToWorldBackward(state.gaussians, gradients, steps_.overflowed());
  }
  // Plasticity is that of the photometric loss alone: before the regulariser adds to the gradient.
  ScopedPhase phase(times_, Phase::kDensity);
  const View<const float> radii = drawing_.tape->radii();
  if (step.plan.gathers_statistics)
    state.statistics.Accumulate(radii,
                                drawing_.screen,
                                gradients.values[kScaleLog],
                                state.gaussians.values[kScaleLog],
                                drawing_.image.width,
                                drawing_.image.height,
                                steps_.overflowed(),
                                stream_);
  if (step.masked) LearnMask(step);
  if (pruner_ && on_host()) pruner_->AfterBackward(state.gaussians, gradients, radii);
}

void StepEngine::LearnMask(SubmittedStep& step) {
  mask_.AfterBackward(state_.now().gaussians,
                      drawing_.tape->radii(),
                      steps_.overflowed(),
                      drawing_.gradients,
                      stream_);
  step.of_mask.Ask(mask_.value(), stream_);
}

void StepEngine::WeakenShapes(Gaussians& gradients) {
  for (const Attribute a : {kScaleLog, kOpacityLogit}) {
    Buffer<float>& values = gradients.values[a];
    ForEach(values.size(), stream_, Weaken{kShapeShareOfGuess, values.view()});
  }
}

View<const float> StepEngine::Regularize(SubmittedStep& step,
                                         View<const float> visible,
                                         float color_curvature,
                                         Gaussians& gradients) {
  const Gaussians& gaussians = state_.now().gaussians;
  if (color_curvature > 0 && gaussians.degree > 0) {
    ColorCurvatureBackward kernel{{},
                                  visible,
                                  gaussians.values[kColorRest].view(),
                                  gradients.values[kColorRest].view(),
                                  size_t(gaussians.width(kColorRest))};
    for (size_t k = 0; k < kernel.width; ++k)
      kernel.weights[k] = color_curvature * CurvatureWeight(gaussians.basis, 1 + int(k) / 3);
    ForEach(gaussians.size(), stream_, kernel);
  }
  if (!needles_.acts()) return visible;
  const View<const float> updated =
      needles_.Backward(gaussians, visible, count(), shards(), gradients);
  step.of_needles.Ask(needles_.value(), stream_);
  return updated;
}

void StepEngine::Update(const StepPlan& plan,
                        View<const float> updated,
                        const Gaussians& gradients) {
  ScopedPhase phase(times_, Phase::kAdam);
  TrainingState& state = state_.Write();
  AdamStepAll(plan.rates,
              gradients,
              subject_.PositionRateScale(),
              updated,
              state.gaussians,
              state.adam,
              stream_,
              steps_.overflowed());
}

const float* StepEngine::ExposureOf(size_t frame) const {
  return settings_.exposure ? state_.now().exposures.value.data() + frame * math::kExposureNumbers
                            : nullptr;
}

void StepEngine::UpdateExposure(const StepPlan& plan, const Buffer<float>& gradient) {
  loss_.photograph().Update(plan.frame,
                            plan.exposure_rate,
                            gradient,
                            steps_.overflowed(),
                            state_.Write().exposures,
                            stream_);
}

double StepEngine::StepOfSeveral(std::span<const StepPlan> views) {
  const StepPlan& plan = views.front();  // what does not differ between them
  TrainingState& state = state_.Write();
  const std::vector<ViewResult> results = batch_.Run(
      views, state, drawing_, times_, [this](const StepPlan& view) { return DrawOwn(view); });
  double loss = 0;
  for (const ViewResult& result : results) loss += result.loss;
  loss /= double(results.size());
  CheckLoss(loss, plan.iteration);
  GradientSum& sum = batch_.sum();
  const bool updates_all = settings_.adam_on == AdamOn::kAll;
  if (needles_.acts() || updates_all) sum.ZeroUnseen();
  SubmittedStep& step = steps_.alone();
  const View<const float> updated = Regularize(
      step, sum.update_mask(), float(views.size()) * plan.color_curvature, sum.gradients());
  Update(plan, updates_all ? View<const float>() : updated, sum.gradients());
  if (settings_.exposure)
    for (size_t v = 0; v < views.size(); ++v)
      UpdateExposure(views[v], batch_.Uploaded(results[v].exposure));
  stream_.Wait();
  return loss + (needles_.acts() ? step.of_needles.Last() : 0);
}

ViewResult StepEngine::DrawOwn(const StepPlan& plan) {
  SubmittedStep& step = steps_.alone();
  step.plan = plan;
  const RenderSettings render = loss_.RenderOf(plan);
  const Camera camera = Reduced(subject_.camera(plan.frame), plan.downscale);
  CheckArguments(drawing_.world, camera, render);
  device_.rasterizer->Draw(camera, render, drawing_.image, *drawing_.tape);
  FinishDrawing(step);
  {
    ScopedPhase phase(times_, Phase::kLoss);
    loss_.Evaluate(ExposureOf(plan.frame), drawing_.image, step);
  }
  device_.rasterizer->DrawBackward(drawing_.image, loss_.d_color(), *drawing_.tape);
  ViewResult result;
  if (settings_.exposure) loss_.d_exposure().Download(result.exposure.data(), stream_);
  stream_.Wait();
  result.loss = step.photometric.Last() + step.of_crop;
  return result;
}

ExchangeStatistics StepEngine::Exchanged() const {
  return batch_.Exchanged(state_.shards(), state_.assembled());
}

PhaseTimes StepEngine::Times() const {
  if (!on_host()) return {};  // submitted work takes the host no time
  PhaseTimes times = times_;
  return times += device_.rasterizer->times;
}

}  // namespace cosplat
