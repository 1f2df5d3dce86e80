#include "splat/train/step/step_engine.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "splat/base/error.h"
#include "splat/device/for_each.h"
#include "splat/device/sum_tree.h"
#include "splat/render/kernels/project.h"
#include "splat/train/density/bands.h"
#include "splat/train/density/kernels/smoothing.h"
#include "splat/train/loss/kernels/crop.h"
#include "splat/train/ranks/kernels/shards.h"

namespace cosplat {
namespace {

constexpr double kTargetShare = 0.25;            // of the initially free memory
constexpr double kGrowth = 1 + 1.0 / kHeadRoom;  // growth of a Buffer

// Bytes per Gaussian besides parameters, gradients and moments: three statistics and their swap
// memory, which of them move, of one view and of several, the screen gradient, and density control.
constexpr double kBesideParameters = 5 * sizeof(float) + 2 * sizeof(float) + 4 * sizeof(uint64_t) +
                                     6 * sizeof(uint32_t) + 2 * sizeof(uint8_t) + 4 * sizeof(float);

// Likewise, where ranks divide the Gaussians: what density control needs of all of them (position,
// rotation, scale, opacity, colour, smoothing), twice while they are reordered, and what is sent of
// a view.
constexpr double kOfOtherRanks =
    30 * sizeof(float) + 3 * (sizeof(ProjectedSplat) + sizeof(float)) + 2 * sizeof(SplatGradient);

void CheckRule(PruneRule rule) {
  if (WorksOnProcessorOnly(rule))
    throw Error("--prune " + ToString(rule),
                "runs on the CPU in every step: use --device cpu or another rule");
}

size_t TargetBytes(const Stream& stream, double share) {
  return stream.on_host() ? 0 : size_t(kTargetShare * share * double(stream.FreeMemory()));
}

std::string NoticeOfMemory(double free, size_t gaussians) {
  char text[160];
  std::snprintf(text,
                sizeof text,
                "GPU memory is nearly full (%.2f GB free): training continues with about %zu "
                "Gaussians",
                1e-9 * free,
                gaussians);
  return text;
}

}  // namespace

void CheckLoss(double loss, int iteration) {
  if (!std::isfinite(loss))
    throw Error("iteration " + std::to_string(iteration), "the loss is not finite");
}

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
      state_(state),
      device_(std::move(device)),
      stream_(device_.rasterizer->stream()),
      now_(stream_.on_host() ? &state_ : &on_device_),
      targets_(subject, TargetBytes(stream_, device_.memory_share)),
      shards_(*device_.ranks),
      exchange_(*device_.ranks, *device_.rasterizer),
      all_(shards_, stream_),
      sum_(stream_),
      tape_(device_.rasterizer->MakeTape()),
      forecast_(forecast),
      steps_{Submitted(stream_), Submitted(stream_)} {
  if (!on_host()) CheckRule(settings.prune.rule);
  CheckBatch();
  if (shards_.divides()) {
    state_.gaussians = shards_.OwnOf(state_.gaussians);
    state_.statistics.Reset(state_.gaussians.size());
  }
  if (state_.adam.updated.empty()) state_.adam = AdamState(state_.gaussians);
  subject_.WorkIn(stream_);
  try {
    Store();
  } catch (const std::exception&) {
    subject_.WorkIn(HostStream());  // this engine's stream is about to be destroyed
    throw;
  }
}

void StepEngine::CheckBatch() const {
  const std::string option = "--batch " + std::to_string(settings_.batch);
  if (device_.ranks->size() > size_t(settings_.batch))
    throw Error(option,
                "has fewer views than the " + std::to_string(device_.ranks->size()) +
                    " ranks that would share them");
  if (settings_.batch == 1) return;
  if (WorksOnProcessorOnly(settings_.prune.rule) || LearnsMask(settings_.prune.rule))
    throw Error("--prune " + ToString(settings_.prune.rule),
                "works in steps of one view: use --batch 1 or another rule");
  if (!subject_.is_static()) throw Error(option, "needs a scene that does not move");
}

StepEngine::~StepEngine() {
  try {
    stream_.Wait();  // steps in flight use what is destroyed now
    subject_.WorkIn(HostStream());
  } catch (const std::exception&) {
    // The error was reported by the call that waited first.
  }
}

Population StepEngine::Everyone() {
  Assemble(AllGaussians::Extent::kGeometry);
  const bool divides = shards_.divides();
  if (divides) all_.ForgetBands();
  canvas_.emplace(Canvas{*device_.rasterizer, image_, *tape_});
  return {subject_,
          divides ? all_.gaussians() : now_->gaussians,
          now_->adam,
          divides ? all_.statistics() : now_->statistics,
          gradients_,
          stream_,
          &*canvas_,
          pruner_,
          mask_.learns() ? &mask_ : nullptr,
          divides ? &shards_ : nullptr,
          divides ? &now_->gaussians : nullptr};
}

// Releases what is sized by the number of Gaussians: it is not needed while they are copied and is
// allocated again afterwards, for the new number. On a device, where that waits, only what density
// control makes larger than steps need it, and what it needs the room of.
void StepEngine::ReleaseScratch() {
  if (!on_host()) {
    if (settings_.batch == 1 || FitsInOnePart()) return;
    gradients_ = {};
    sum_.Release();
    exchange_.Release();
    return;
  }
  gradients_ = {};
  screen_ = {};
  moves_ = {};
  sum_.Release();
  exchange_.Release();
  shards_.Release();
  density_.Release();
  tape_ = device_.rasterizer->MakeTape();
}

void StepEngine::StoreMask() { mask_.Upload(pruner_ ? pruner_->Mask() : MaskInSteps(), stream_); }

void StepEngine::SetPruner(Pruner* pruner) {
  pruner_ = pruner;
  StoreMask();
}

void StepEngine::Store() {
  if (!on_host()) {
    on_device_.gaussians.Upload(state_.gaussians, stream_);
    on_device_.adam.Upload(state_.adam, stream_);
    on_device_.statistics.Upload(state_.statistics, stream_);
    on_device_.exposures.Upload(state_.exposures, stream_);
  }
  ReleaseScratch();
  if (settings_.batch == 1) gradients_.RefillLike(now_->gaussians, stream_);
  overflowed_.Refill(1, stream_);
  overflowed_.FillWithZeros(stream_);
  StoreMask();
  stream_.Wait();  // the copies read the state's memory
  in_flight_ = 0;  // those steps belong to another state
  fetched_ = true;
  count_ = size_t(Sum(now_->gaussians.size(), *device_.ranks));
  all_.Release();
}

void StepEngine::Fetch() {
  if (fetched_) return;
  Settle(0);
  if (!on_host()) {
    on_device_.gaussians.Download(state_.gaussians, stream_);
    on_device_.adam.Download(state_.adam, stream_);
    on_device_.statistics.Download(state_.statistics, stream_);
    on_device_.exposures.Download(state_.exposures, stream_);
    stream_.Wait();
  }
  mask_.Download(stream_);
  fetched_ = true;
}

StepEngine::Ranked StepEngine::FetchForRanking() {
  Assemble(AllGaussians::Extent::kGeometry);
  mask_.Download(stream_);
  const bool divides = shards_.divides();
  if (on_host()) {
    if (divides) return {all_.gaussians(), all_.statistics()};
    return {state_.gaussians, state_.statistics};
  }
  const Gaussians& from = Shown();
  Gaussians& to = divides ? ranked_ : state_.gaussians;
  DensityStatistics& statistics = divides ? ranked_statistics_ : state_.statistics;
  if (divides) {
    to.degree = from.degree;
    to.basis = from.basis;
    to.antialiased = from.antialiased;
  }
  to.Resize(count());
  for (int a = 0; a < kAttributeCount; ++a)
    if (a != kColorRest && a != kCorrection) from.values[a].Download(to.values[a].data(), stream_);
  to.degrees.resize(from.degrees.size());
  from.degrees.Download(to.degrees.data(), stream_);
  to.smoothing.resize(from.smoothing.size());
  from.smoothing.Download(to.smoothing.data(), stream_);
  (divides ? all_.statistics() : on_device_.statistics).Download(statistics, stream_);
  stream_.Wait();
  return {to, statistics};
}

Gaussians StepEngine::CaughtUp(const AdamSettings& rates) {
  Fetch();
  ReleaseScratch();
  const Buffer<uint32_t>& updated = state_.adam.updated;
  const bool up_to_date = std::all_of(
      updated.begin(), updated.end(), [&](uint32_t step) { return step == state_.adam.step; });
  if (up_to_date) return shards_.AllOf(state_.gaussians, count());  // as at the end of a run
  Gaussians gaussians = state_.gaussians;
  {
    AdamState adam = state_.adam;
    const View<const float> scale = subject_.PositionRateScale();
    Buffer<float> of_host(scale.count);
    if (!scale.empty()) stream_.Download(of_host.data(), scale.data, scale.count * sizeof(float));
    stream_.Wait();
    AdamCatchUpAll(rates, of_host, gaussians, adam);
  }
  return shards_.divides() ? shards_.AllOf(gaussians, count()) : std::move(gaussians);
}

void StepEngine::CatchUp(const AdamSettings& rates) {
  Settle(0);
  AdamCatchUpAll(rates, subject_.PositionRateScale(), now_->gaussians, now_->adam, stream_);
  all_.Release();
  fetched_ = false;
}

void StepEngine::AfterStep(int iteration) {
  if (!subject_.ActsAfter(iteration)) return;
  Settle(0);
  subject_.Act(iteration, now_->gaussians, now_->adam);
  all_.Release();
  fetched_ = false;
}

// Bytes per Gaussian where rankings or dropped bands assemble all attributes.
double StepEngine::OfWhole(size_t numbers) const {
  const bool assembles = settings_.prune.rule != PruneRule::kNone || settings_.drop_bands > 0;
  return shards_.divides() && assembles ? sizeof(float) * double(numbers) : 0;
}

bool StepEngine::FitsInOnePart() const {
  return settings_.batch > 1 && now_->gaussians.size() < kRowsPerPart;
}

size_t StepEngine::MostThatFit() {
  if (on_host()) return size_t(-1);
  size_t numbers = 0;
  for (int a = 0; a < kAttributeCount; ++a) numbers += size_t(now_->gaussians.width(a));
  // Of the rank's share parameters, gradients (of one view or summed) and moments.
  const double ranks = double(shards_.share().ranks), copies = FitsInOnePart() ? 5 : 4;
  const double per_gaussian = copies * sizeof(float) * double(numbers) / ranks + kBesideParameters +
                              (shards_.divides() ? kOfOtherRanks : 0) + OfWhole(numbers) +
                              device_.rasterizer->BytesPerGaussian(instances_per_gaussian_) +
                              double(subject_.BytesPerGaussian());
  size_t held = 0;
  for (const MemoryPart& part : Memory())
    if (part.of == MemoryOf::kGaussians) held += part.bytes;
  const double most = (double(held) + kUsableMemory * FreeMemory()) / (kGrowth * per_gaussian);
  return Smallest(uint32_t(std::min(most, double(UINT32_MAX))), *device_.ranks);
}

void StepEngine::ControlDensity(const DensitySettings& settings, bool remove_oversized) {
  DensitySettings limited = settings;
  limited.max_count = std::min(settings.max_count, MostThatFit());
  ReleaseScratch();
  if (shards_.divides()) {
    Gaussians& own = now_->gaussians;
    ForEach(own.size(),
            stream_,
            SpoilBroken{std::as_const(own.values[kColorRest]).view(),
                        size_t(own.width(kColorRest)),
                        own.values[kColorDc].view()});
  }
  const DensityReport report = density_.Control(limited, remove_oversized, Everyone(), state_.rng);
  TakeOwn();
  instances_per_gaussian_ = 0;
  if (!report.held_back || limited.max_count == settings.max_count || told_of_memory_) return;
  told_of_memory_ = true;
  notice_ = NoticeOfMemory(FreeMemory(), count());
}

void StepEngine::Prune(const PruneRound& round, int group_cap, int group_floor) {
  StoreMask();  // ranking may have started or ended mask learning
  density_.Prune(round, group_cap, group_floor, Everyone());
  TakeOwn();
  ranked_ = {};
  ranked_statistics_ = {};
}

void StepEngine::SortInSpace() {
  density_.SortInSpace(Everyone());
  TakeOwn();
  ReleaseScratch();
}

void StepEngine::ResetStatistics() {
  now_->statistics.Reset(now_->gaussians.size(), stream_);
  all_.Release();
  fetched_ = false;
}

void StepEngine::ResetOpacity() {
  cosplat::ResetOpacity(now_->gaussians, now_->adam, stream_);
  all_.Release();
  fetched_ = false;
}

void StepEngine::UpdateSmoothing() {
  Settle(0);  // a step that is repeated must find the filter it had
  if (sampling_views_.empty()) {
    Buffer<math::Pinhole<float>> views;
    for (size_t i = 0; i < subject_.frame_count(); ++i)
      views.push_back(math::ToPinhole<float>(ViewOfCamera(subject_.camera(i), {}, 0)));
    sampling_views_.Upload(views.data(), views.size(), stream_);
    stream_.Wait();
  }
  Gaussians& g = now_->gaussians;
  g.smoothing.Refill(g.size(), stream_);
  ForEach(g.size(),
          stream_,
          FindSmoothing{std::as_const(sampling_views_).view(),
                        std::as_const(g.values[kPosition]).view(),
                        g.smoothing.view()});
  all_.Release();
  fetched_ = false;
}

double StepEngine::Step(const StepPlan& given) {
  StepPlan plan = given;
  const bool has_crop = settings_.crop_loss.weight != 0;
  if (has_crop)
    plan.crop = DrawCrop(
        targets_.ImageOf(plan.frame, plan.downscale), settings_.crop_loss.side, state_.rng);
  const Rng rng = state_.rng;
  state_.rng = rng.After(mask_.DrawsOf(count()));
  Submit(plan, rng, on_host() || subject_.WaitsInSteps() || has_crop || !forecast_.Knows());
  Settle(!on_host() && last_loss_ ? 1 : 0);
  return *last_loss_;
}

void StepEngine::Submit(const StepPlan& plan, const Rng& rng, bool waits) {
  Submitted& step = steps_[(oldest_ + in_flight_) % kInFlight];
  step.plan = plan;
  step.rng = rng;
  step.masked = mask_.learns();
  Draw(step, waits);
  Backward(step);
  const View<const float> moves = RegularizeScale(step, tape_->radii(), gradients_);
  Update(plan, settings_.adam_on == AdamOn::kAll ? View<const float>() : moves, gradients_);
  if (settings_.exposure)
    photograph_.Update(plan.frame,
                       plan.exposure_rate,
                       photograph_.gradient(),
                       overflowed_.data(),
                       now_->exposures,
                       stream_);
  step.done->Record();
  ++in_flight_;
  fetched_ = false;
}

void StepEngine::Settle(size_t left) {
  for (; in_flight_ > left; --in_flight_, oldest_ = (oldest_ + 1) % kInFlight) {
    const Submitted& step = steps_[oldest_];
    step.done->Wait();
    if (step.counts.Last().instances > step.capacity) {
      Repeat();
      step.done->Wait();
    }
    if (!on_host()) forecast_.Saw(step.plan.frame, count(), step.counts.Last().instances);
    last_loss_ = LossOf(step);
  }
}

void StepEngine::Repeat() {
  overflowed_.FillWithZeros(stream_);
  now_->adam.step -= uint32_t(in_flight_);
  mask_.TakeBack(int64_t(in_flight_));
  const size_t count = std::exchange(in_flight_, 0);
  for (size_t k = 0; k < count; ++k) {
    const Submitted& step = steps_[(oldest_ + k) % kInFlight];
    Submit(StepPlan(step.plan), Rng(step.rng), true);
  }
}

double StepEngine::LossOf(const Submitted& step) const {
  double loss = step.photometric.Last() + step.of_crop;
  CheckLoss(loss, step.plan.iteration);
  if (step.masked) loss += step.of_mask.Last();
  if (settings_.scale_regularizer.weight != 0) loss += step.of_needles.Last();
  return loss;
}

void StepEngine::Draw(Submitted& step, bool waits) {
  const StepPlan& plan = step.plan;
  {
    ScopedPhase phase(times_, Phase::kData);
    if (gradients_.size() != count()) gradients_.RefillLike(now_->gaussians, stream_);
  }
  {
    ScopedPhase phase(times_, Phase::kPose);
    world_ = subject_.Place(now_->gaussians, plan.frame);
    if (step.masked) mask_.BeforeDraw(now_->gaussians, step.rng, world_, stream_);
  }
  if (!waits) tape_->Expect(forecast_.Of(plan.frame, count()), overflowed_.data());
  device_.rasterizer->Forward(world_,
                              now_->gaussians.basis,
                              targets_.CameraOf(plan.frame, plan.downscale),
                              RenderOf(plan),
                              image_,
                              *tape_);
  FinishDrawing(step);
}

RenderSettings StepEngine::RenderOf(const StepPlan& plan) {
  RenderSettings render = plan.render;
  if (!targets_.LayersOf(plan.frame, plan.downscale).empty()) render.background = {0, 0, 0};
  return render;
}

void StepEngine::FinishDrawing(Submitted& step) {
  const StepPlan& plan = step.plan;
  const FrameLayers& layers = targets_.LayersOf(plan.frame, plan.downscale);
  if (!layers.empty()) layers_.AddBehind(layers, plan.render.background, image_, stream_);
  step.counts.Ask(tape_->counts(), stream_);
  step.capacity = tape_->capacity();
  instances_per_gaussian_ =
      std::max(instances_per_gaussian_, double(step.capacity) / double(count()));
}

void StepEngine::Evaluate(Submitted& step) {
  const StepPlan& plan = step.plan;
  ScopedPhase phase(times_, Phase::kLoss);
  const TargetView target = targets_.Of(plan.frame, plan.downscale, stream_);
  const float* const exposure = ExposureOf(plan.frame);
  const FrameLayers& layers = targets_.LayersOf(plan.frame, plan.downscale);
  const Buffer<float>& scene =
      layers.empty() ? image_.color : layers_.Show(layers, image_.color, stream_);
  const bool as_is = !exposure && !target.ignored;
  const Buffer<float>& shown =
      as_is ? scene : photograph_.Show(scene, exposure, target, plan.render.background, stream_);
  device_.loss->Evaluate(settings_.loss, shown, target, plan.render.background, d_color_, stream_);
  step.photometric.Ask(device_.loss->value(), stream_);
  if (settings_.crop_loss.weight != 0) AddCropLoss(step, shown);
  if (!as_is) photograph_.Pull(scene, exposure, target, d_color_, stream_);
  if (!layers.empty()) layers_.Pull(layers, d_color_, stream_);
}

void StepEngine::Backward(Submitted& step) {
  Evaluate(step);
  // On the host nothing has changed yet.
  if (on_host()) CheckLoss(step.photometric.Last() + step.of_crop, step.plan.iteration);
  WorldGradients d_world = subject_.WorldGradientsFor(gradients_, screen_, stream_);
  // Adam then also reads the gradients of other groups.
  if (settings_.adam_on == AdamOn::kAll || settings_.scale_regularizer.weight != 0)
    d_world.drawn_groups_only = false;
  device_.rasterizer->Backward(world_, image_, d_color_, *tape_, d_world);
  {
    ScopedPhase phase(times_, Phase::kPose);
    subject_.PlaceBackward(now_->gaussians, gradients_, overflowed_.data());
  }
  // Plasticity is that of the photometric loss alone: before the regulariser adds to the gradient.
  ScopedPhase phase(times_, Phase::kDensity);
  if (step.plan.gathers_statistics)
    now_->statistics.Accumulate(tape_->radii(),
                                screen_,
                                gradients_.values[kScaleLog],
                                now_->gaussians.values[kScaleLog],
                                image_.width,
                                image_.height,
                                overflowed_.data(),
                                stream_);
  if (step.masked) LearnMask(step);
  if (pruner_ && on_host()) pruner_->AfterBackward(state_.gaussians, gradients_, tape_->radii());
}

const float* StepEngine::ExposureOf(size_t frame) const {
  return settings_.exposure ? now_->exposures.value.data() + frame * math::kExposureNumbers
                            : nullptr;
}

void StepEngine::AddCropLoss(Submitted& step, const Buffer<float>& shown) {
  const CropLossSettings& settings = settings_.crop_loss;
  const StepPlan& plan = step.plan;
  const CropPlaces places{plan.crop, image_.width, image_.height};
  const size_t numbers = 3 * size_t(plan.crop.width) * size_t(plan.crop.height);
  crop_.Refill(numbers, stream_);
  ForEach(numbers, stream_, CopyCrop{places, shown.view(), crop_.view()});
  rendered_crop_.resize(numbers);
  crop_.Download(rendered_crop_.data(), stream_);
  stream_.Wait();
  // On a device this shows before its loss does.
  const bool finite = std::all_of(
      rendered_crop_.begin(), rendered_crop_.end(), [](float v) { return std::isfinite(v); });
  if (settings_.batch == 1) CheckLoss(finite ? 0 : NAN, plan.iteration);
  if (!finite) {  // of several views: all ranks throw together
    step.of_crop = NAN;
    return;
  }
  CompositeTarget(Cropped(targets_.ImageOf(plan.frame, plan.downscale), plan.crop),
                  plan.render.background,
                  target_crop_);
  step.of_crop = settings.weight *
                 settings.distance->Evaluate(
                     rendered_crop_, target_crop_, plan.crop.width, plan.crop.height, d_crop_);
  stream_.Send(crop_.data(), d_crop_.data(), numbers * sizeof(float));
  ForEach(numbers,
          stream_,
          AddCrop{places, settings.weight, std::as_const(crop_).view(), d_color_.view()});
}

void StepEngine::LearnMask(Submitted& step) {
  mask_.AfterBackward(now_->gaussians, tape_->radii(), overflowed_.data(), gradients_, stream_);
  step.of_mask.Ask(mask_.value(), stream_);
}

View<const NeedleSum> StepEngine::SumNeedles(const NeedleRule& rule) {
  const Needles own{rule, std::as_const(now_->gaussians.values[kScaleLog]).view()};
  if (!shards_.divides()) return SumInTree(own, needle_sums_, stream_);
  static_assert(kRowsPerBlock % kSumBlock == 0);
  needle_sums_.Refill(SumBlockCount(own.size()), stream_);
  ForEach(needle_sums_.size(), stream_, SumBlocks<Needles>{own, needle_sums_.view()});
  Buffer<NeedleSum> sums(needle_sums_.size());
  needle_sums_.Download(sums.data(), stream_);
  stream_.Wait();
  sums = shards_.Assembled(sums, {0, count(), 1, kSumBlock}, ForWhom::kAllRanks);
  all_needle_sums_.Upload(sums.data(), sums.size(), stream_);
  stream_.Wait();
  return SumInTree(std::as_const(all_needle_sums_).view(), needle_sums_, stream_);
}

View<const float> StepEngine::RegularizeScale(Submitted& step,
                                              View<const float> visible,
                                              Gaussians& gradients) {
  const ScaleRegularizer& settings = settings_.scale_regularizer;
  if (settings.weight == 0) return visible;
  const size_t n = now_->gaussians.size();
  const NeedleRule rule{std::log(settings.limit), std::log(settings.ratio)};
  const View<const float> scale_log = std::as_const(now_->gaussians.values[kScaleLog]).view();
  needles_.Refill(1, stream_);
  moves_.Refill(n, stream_);
  ForEach(1, stream_, AddUpNeedles{SumNeedles(rule), settings.weight, needles_.data()});
  ForEach(n,
          stream_,
          PullNeedles{rule,
                      scale_log,
                      visible,
                      needles_.data(),
                      gradients.values[kScaleLog].view(),
                      moves_.view()});
  step.of_needles.Ask(&needles_.data()->value, stream_);
  return std::as_const(moves_).view();
}

void StepEngine::Update(const StepPlan& plan, View<const float> moves, const Gaussians& gradients) {
  ScopedPhase phase(times_, Phase::kAdam);
  AdamStepAll(plan.rates,
              gradients,
              subject_.PositionRateScale(),
              moves,
              now_->gaussians,
              now_->adam,
              stream_,
              overflowed_.data());
}

void StepEngine::Assemble(AllGaussians::Extent extent) {
  if (shards_.divides()) all_.Assemble(extent, now_->gaussians, now_->statistics, count());
}

void StepEngine::TakeOwn() {
  fetched_ = false;
  count_ = Shown().size();
  if (shards_.divides()) all_.ShareOut(now_->gaussians, now_->statistics);
}

const Gaussians& StepEngine::Shown() const {
  return shards_.divides() ? all_.gaussians() : now_->gaussians;
}

double StepEngine::DropBands(float threshold,
                             View<const uint32_t> frames,
                             const std::array<float, 3>& background) {
  Fetch();
  const auto zero_moments = [this] {
    for (Gaussians* moments : {&state_.adam.m, &state_.adam.v})
      ZeroAbove(state_.gaussians.degrees, *moments);
  };
  if (!shards_.divides())
    return DropBandsInTraining(threshold, *this, frames, background, state_.gaussians, [&] {
      zero_moments();
      Store();
    });
  Assemble(AllGaussians::Extent::kWhole);
  Gaussians all;
  all_.gaussians().Download(all, stream_);
  stream_.Wait();
  const double change = DropBandsInTraining(threshold, *this, frames, background, all, [&] {
    state_.gaussians.degrees.resize(state_.gaussians.size());
    shards_.TakeOwn(all.degrees, {0, count()}, state_.gaussians.degrees);
    ZeroAbove(state_.gaussians.degrees, state_.gaussians);
    zero_moments();
    Store();
    Assemble(AllGaussians::Extent::kWhole);
  });
  all_.Release();
  return change;
}

ExchangeStatistics StepEngine::Exchanged() const {
  Ranks& ranks = *device_.ranks;
  ExchangeStatistics all = exchanged_;
  all.assembled = all_.assembled();
  all.ranks = ranks.size();
  // Before the sums, which send something themselves.
  const uint64_t bytes = ranks.bytes_sent(), microseconds = uint64_t(1e6 * ranks.seconds());
  all.bytes_sent = Sum(bytes, ranks);
  all.seconds = 1e-6 * double(Sum(microseconds, ranks)) / double(ranks.size());
  all.groups_drawn = Sum(exchange_.groups_drawn(), ranks);
  all.groups_updated = Sum(exchanged_.groups_updated, ranks);
  all.handed_over = Sum(shards_.numbers_sent(), ranks);
  return all;
}

std::vector<Contribution> StepEngine::Contributions(const FrameChoice& choice) {
  Assemble(AllGaussians::Extent::kWhole);
  const Gaussians& shown = Shown();
  contributions_.Refill(count(), stream_);
  contributions_.FillWithZeros(stream_);
  for (size_t k = 0; k < choice.count(); ++k) {
    device_.rasterizer->Forward(subject_.Place(shown, choice[k]),
                                shown.basis,
                                subject_.camera(choice[k]),
                                {choice.background, choice.degree},
                                image_,
                                *tape_);
    device_.rasterizer->Contributions(image_, *tape_, of_image_);
    ForEach(
        count(), stream_, AddContributions{std::as_const(of_image_).view(), contributions_.view()});
  }
  std::vector<Contribution> sums(count());
  contributions_.Download(sums.data(), stream_);
  stream_.Wait();
  return sums;
}

double StepEngine::MeanPsnr(const FrameChoice& choice) {
  Assemble(AllGaussians::Extent::kWhole);
  return MeanPsnrOfFrames(
      subject_, Shown(), choice, settings_.exposure, *device_.rasterizer, *tape_);
}

double StepEngine::MeanPsnrOf(const Gaussians& gaussians, const FrameChoice& choice) {
  Gaussians copy;
  if (!on_host()) copy.Upload(gaussians, stream_);
  return MeanPsnrOfFrames(subject_,
                          on_host() ? gaussians : copy,
                          choice,
                          settings_.exposure,
                          *device_.rasterizer,
                          *tape_);
}

PhaseTimes StepEngine::Times() const {
  if (!on_host()) return {};  // submitted work takes the host no time
  PhaseTimes times = times_;
  return times += device_.rasterizer->times;
}

std::vector<MemoryPart> StepEngine::Memory() const {
  const DensityStatistics& d = now_->statistics;
  std::vector<MemoryPart> parts{
      {"parameters", HeldBy(now_->gaussians)},
      {"gradients",
       HeldBy(gradients_),
       settings_.batch == 1 || FitsInOnePart() ? MemoryOf::kGaussians : MemoryOf::kFixed},
      {"gradients summed over views", sum_.held()},
      {"messages between ranks", shards_.HeldByMessages(), MemoryOf::kFixed},
      {"views exchanged between ranks", exchange_.held()},
      {"Gaussians of all ranks", HeldBy(all_.gaussians())},
      {"first moments", HeldBy(now_->adam.m)},
      {"second moments", HeldBy(now_->adam.v)},
      {"Adam group state", HeldBy(now_->adam.updated, now_->adam.behind, moves_)},
      {"learned mask", mask_.held()},
      {"density statistics", HeldBy(d.screen_gradient, d.plasticity, d.visible)},
      {"density control", density_.held()},
      {"screen gradients", HeldBy(screen_)},
      {"reduction and sort scratch", stream_.held() + HeldBy(contributions_, of_image_)},
      {"image and its gradient",
       HeldBy(image_.color, image_.transmittance, d_color_, crop_) + photograph_.held() +
           layers_.held(),
       MemoryOf::kPixels},
      {"target images", targets_.held(), MemoryOf::kPixels},
      {"downscaled target images", targets_.HeldForReduced(), MemoryOf::kPixels}};
  for (MemoryPart& part : tape_->Memory()) parts.push_back(std::move(part));
  for (MemoryPart& part : subject_.Memory()) parts.push_back(std::move(part));
  std::erase_if(parts, [](const MemoryPart& part) { return part.bytes == 0; });
  return parts;
}

}  // namespace cosplat
