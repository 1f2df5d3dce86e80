#include "splat/train/trainer.h"

#include <algorithm>
#include <chrono>
#include <climits>
#include <string>
#include <utility>

#include "splat/base/error.h"
#include "splat/train/serialize_state.h"

namespace cosplat {
namespace {

constexpr int kMinReducedSide = 100;          // px
constexpr float kLastCorrectionRate = 0.01f;  // as a fraction of the first
constexpr float kLastExposureRate = 0.1f;     // likewise

int MinSide(const Subject& subject) {
  int min = INT_MAX;
  for (size_t i = 0; i < subject.frame_count(); ++i) {
    const Camera& camera = subject.camera(i);
    min = std::min({min, camera.width, camera.height});
  }
  return min;
}

}  // namespace

Trainer::Trainer(const TrainSettings& settings,
                 Subject& subject,
                 Gaussians first,
                 const StepEngineMaker& make_engine)
    : settings_(settings), subject_(subject) {
  if (subject.frame_count() == 0) throw Error("training frames", "there are no training frames");
  min_side_ = MinSide(subject);
  CheckCropLoss();
  state_.gaussians = std::move(first);
  state_.gaussians.antialiased = settings.antialiasing;
  state_.statistics.Reset(state_.gaussians.size());
  state_.rng.state = settings.seed;
  state_.iteration = settings.first_iteration;
  if (settings.exposure) state_.exposures = ExposureState(subject.frame_count());
  HoldOut({});
  engine_ = make_engine(settings_, subject_, state_);
  MakePrunerFor(count());
  UpdateSmoothing();
}

void Trainer::CheckCropLoss() const {
  if (settings_.crop_loss.weight == 0) return;
  const int min = settings_.crop_loss.distance->min_side();
  if (std::min(min_side_, settings_.crop_loss.side) < min)
    throw Error("training frames",
                "the perceptual loss needs crops of at least " + SizeText(min, min) +
                    " pixels; the smallest side is " + std::to_string(min_side_) +
                    ", that of the crops " + std::to_string(settings_.crop_loss.side));
}

void Trainer::MakePrunerFor(size_t gaussians) {
  pruner_ = MakePruner(settings_.prune, settings_.schedule, settings_.iterations, gaussians);
  engine_->SetPruner(pruner_.get());
}

const TrainingState& Trainer::state() const {
  engine_->Fetch();
  return state_;
}

void Trainer::CheckSomeAreLeft(int iteration) const {
  if (count() == 0)
    throw Error("iteration " + std::to_string(iteration), "every Gaussian was pruned");
}

int Trainer::active_degree() const {
  const int raised =
      settings_.first_degree + settings_.schedule.DegreeAt(state_.iteration, settings_.degree);
  return std::min(raised, settings_.degree);
}

// Every frame once per pass, in random order.
size_t Trainer::NextFrame() {
  std::vector<uint32_t>& left = state_.frames_left;
  if (left.empty()) {
    left = frames_;
    if (state_.iteration < settings_.schedule.densify_until)
      std::erase_if(left, [&](uint32_t f) { return subject_.IsGuess(f); });
    for (size_t i = left.size(); i > 1; --i) std::swap(left[i - 1], left[state_.rng.Below(i)]);
  }
  const size_t next = left.back();
  left.pop_back();
  if (settings_.batch == 1 && !left.empty()) subject_.Expect(left.back());
  return next;
}

std::array<float, 3> Trainer::NextBackground() {
  if (settings_.background == Background::kBlack) return {0, 0, 0};
  if (settings_.background == Background::kWhite) return {1, 1, 1};
  std::array<float, 3> color{};
  for (float& c : color) c = state_.rng.Uniform();
  return color;
}

std::array<float, 3> Trainer::MeanBackground() const {
  const bool white = settings_.background == Background::kWhite;
  const float grey = settings_.background == Background::kRandom ? 0.5f : float(white);
  return {grey, grey, grey};
}

// Not before all bands are trained: bands that are not are still zero.
bool Trainer::DropsBandsAt(int iteration) const {
  return settings_.drop_bands > 0 && active_degree() == settings_.degree &&
         BandSchedule::DropsAt(iteration, settings_.iterations);
}

AdamSettings Trainer::RatesAt(int iteration) const {
  const LearningRates& r = settings_.rates;
  AdamSettings adam;
  adam.eps = settings_.eps;
  adam.rate[kPosition] =
      subject_.extent() *
      settings_.schedule.PositionRate(iteration, r.position_lr_init, r.position_lr_final);
  adam.rate[kRotation] = r.rotation;
  adam.rate[kScaleLog] = r.scale;
  adam.rate[kOpacityLogit] = r.opacity;
  adam.rate[kColorDc] = r.color;
  adam.rate[kColorRest] = r.RestRate();
  adam.rate[kCorrection] =
      settings_.schedule.PositionRate(iteration, r.correction, r.correction * kLastCorrectionRate);
  const float share = settings_.schedule.RateShare(iteration);
  for (const Attribute a : {kRotation, kScaleLog, kOpacityLogit, kColorDc, kColorRest})
    adam.rate[a] *= share;
  adam.batch = EndOfStep(iteration) - iteration;
  return adam;
}

int Trainer::EndOfStep(int begin) const {
  // One view at a time beyond the end, where only tests go.
  return std::max(begin + 1, std::min(begin + settings_.batch, settings_.iterations));
}

// Steps begin at multiples of the batch.
AdamSettings Trainer::LastRates() const {
  return RatesAt(std::max(state_.iteration - 1, 0) / settings_.batch * settings_.batch);
}

void Trainer::SetExposures(ExposureState exposures) {
  engine_->Fetch();
  state_.exposures = std::move(exposures);
  engine_->Store();
}

void Trainer::HoldOut(std::vector<uint32_t> frames) {
  std::sort(frames.begin(), frames.end());
  frames_.clear();
  for (uint32_t f = 0; f < subject_.frame_count(); ++f)
    if (!std::binary_search(frames.begin(), frames.end(), f)) frames_.push_back(f);
  if (frames_.empty()) throw Error("training frames", "no frames remain after holding some out");
  state_.frames_left.clear();
}

double Trainer::PsnrOf(View<const uint32_t> frames) {
  const FrameChoice choice{frames, active_degree(), MeanBackground(), frames.size()};
  // At the end of a run no updates are deferred: the Gaussians may be rendered in place.
  if (state_.iteration == settings_.iterations) return engine_->ErrorIn(choice).mean_psnr;
  return engine_->ErrorOf(CaughtUp(), choice).mean_psnr;
}

void Trainer::Serialize(StateArchive& a) {
  if (!a.reads()) engine_->Fetch();
  uint64_t gaussians = count();
  cosplat::Serialize(a, subject_.frame_count(), engine_->shards(), gaussians, state_);
  a.Require(state_.iteration <= settings_.iterations, "iteration", "is beyond the run's end");
  const std::shared_ptr<SubjectState> subject = subject_.SaveState();
  if (subject) subject->Serialize(a, gaussians);
  a.Value("drop_psnr", drop_psnr_);
  a.Value("pruned", pruned_);
  PhaseTimes times = times_;
  times += engine_->Times();
  a.Value("times", times);
  a.Value("seconds", seconds_);
  a.Value("cpu_seconds", cpu_seconds_);
  a.Value("steps", steps_);
  a.Value("last_seconds", last_seconds_);
  if (a.reads()) {
    if (subject) subject_.RestoreState(*subject);
    times_ = times;
    MakePrunerFor(gaussians);
  }
  if (pruner_) pruner_->Serialize(a, gaussians);
  if (a.reads()) engine_->Store();
}

// The ranking for this step: the pruning rule's in its rounds, otherwise by plasticity for the cap
// per group alone.
PruneRound Trainer::Rank(int iteration) {
  const auto [gaussians, statistics] = engine_->FetchForRanking();
  const PruneContext context{iteration,
                             *engine_,
                             frames_,
                             gaussians,
                             statistics,
                             active_degree(),
                             MeanBackground(),
                             state_.rng};
  return PrunesAt(iteration) ? pruner_->Rank(context) : RankByPlasticity(context);
}

void Trainer::DropBands() {
  drop_psnr_ += engine_->DropBands(settings_.drop_bands, frames_, MeanBackground());
}

void Trainer::ControlDensityAt(int iteration) {
  const Schedule& schedule = settings_.schedule;
  const bool densifies = schedule.DensifiesAt(iteration);
  const bool prunes = PrunesAt(iteration);
  const bool resets = schedule.ResetsOpacityAt(iteration);
  const bool drops = DropsBandsAt(iteration);
  if (densifies || prunes || resets || drops || iteration == settings_.iterations)
    engine_->CatchUp(LastRates());
  if (densifies) {
    if (pruner_) pruner_->BeforeDensification();
    engine_->ControlDensity(settings_.density, iteration > schedule.size_prune_after);
    CheckSomeAreLeft(iteration);
  }
  if (densifies || prunes) {
    if (settings_.prune.group_cap > 0 || prunes)
      pruned_ += engine_->Prune(Rank(iteration),
                                settings_.prune.group_cap,
                                FindPruneRule(settings_.prune.rule).group_floor);
    CheckSomeAreLeft(iteration);
    engine_->SortInSpace();
    engine_->ResetStatistics();
  }
  if (resets) engine_->ResetOpacity();
  if (drops) DropBands();
}

// The same for all frames, since an engine keeps the images of a single downscale. No image becomes
// too small for a windowed loss or a network.
int Trainer::DownscaleAt(int iteration) const {
  int downscale = settings_.schedule.DownscaleAt(iteration);
  int min = kMinReducedSide;
  if (settings_.crop_loss.weight != 0)
    min = std::max(min, settings_.crop_loss.distance->min_side());
  while (downscale > 1 && min_side_ < min * downscale) downscale /= 2;
  return downscale;
}

void Trainer::UpdateSmoothing() {
  if (settings_.antialiasing && subject_.is_static()) engine_->UpdateSmoothing();
}

// The plan of the step that begins with this iteration.
StepPlan Trainer::PlanOf(int iteration, size_t frame) {
  float color_curvature = 0;
  if (settings_.color_curvature > 0) {
    const Camera& camera = subject_.camera(frame);
    color_curvature =
        settings_.ColorCurvatureOf(frames_.size(), size_t(3) * camera.width * camera.height);
  }
  return {iteration,
          frame,
          {NextBackground(), active_degree(), settings_.exp_degree},
          RatesAt(state_.iteration),
          iteration < settings_.schedule.densify_until,
          DownscaleAt(iteration),
          {},
          settings_.schedule.PositionRate(
              iteration, settings_.rates.exposure, settings_.rates.exposure * kLastExposureRate),
          color_curvature};
}

StepPlan Trainer::NextView(int iteration) { return PlanOf(iteration, NextFrame()); }

double Trainer::Train(int begin, int end) {
  views_.clear();
  for (int view = begin; view < end; ++view) views_.push_back(NextView(begin + 1));
  return engine_->Step(views_);
}

StepReport Trainer::Step() {
  const auto start = std::chrono::steady_clock::now();
  const double cpu_start = ProcessorSeconds();
  const int begin = state_.iteration, end = EndOfStep(begin);
  const double loss = Train(begin, end);
  {
    ScopedPhase phase(times_, Phase::kDensity);
    state_.iteration = end;
    for (int iteration = begin + 1; iteration <= end; ++iteration) {
      ControlDensityAt(iteration);
      // Not after the last step: the Gaussians would never have been trained with it.
      if (iteration % kSmoothingEvery == 0 && end < settings_.iterations) UpdateSmoothing();
      engine_->AfterStep(iteration);
    }
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  seconds_ += seconds;
  cpu_seconds_ += ProcessorSeconds() - cpu_start;
  last_seconds_[steps_++ % last_seconds_.size()] = seconds;
  return {end, loss, count(), engine_->TakeNotice()};
}

Gaussians Trainer::CaughtUp() const {
  Gaussians gaussians = engine_->CaughtUp(LastRates());
  BakeSmoothing(gaussians);
  return gaussians;
}

Gaussians Trainer::TakeGaussians() {
  engine_->Fetch();
  if (!engine_->shards().divides()) return std::move(state_.gaussians);
  return engine_->shards().AllOf(state_.gaussians, count());
}

TrainingStatistics Trainer::statistics() const {
  engine_->Fetch();
  TrainingStatistics s;
  s.iterations = state_.iteration;
  s.steps = steps_;
  s.seconds = seconds_;
  s.cpu_seconds = cpu_seconds_;
  s.gaussians = count();
  s.times = times_;
  s.times += engine_->Times();
  Shards& shards = engine_->shards();
  s.ignored_gradients = shards.SumOver(state_.adam.ignored[0]);
  s.degrees = CountDegrees(state_.gaussians);
  for (size_t& of_degree : s.degrees) of_degree = shards.SumOver(of_degree);
  s.bands = FiguresOf(s.degrees, state_.gaussians.degree);
  s.drop_psnr = drop_psnr_;
  s.pruned = pruned_;
  s.exchanged = engine_->Exchanged();
  const size_t count = std::min(steps_, last_seconds_.size());
  if (count == 0) return s;
  auto last = last_seconds_;
  std::nth_element(last.begin(), last.begin() + count / 2, last.begin() + count);
  s.ms_per_step = 1e3 * last[count / 2];
  return s;
}

std::vector<MemoryPart> Trainer::Memory() const {
  std::vector<MemoryPart> parts = engine_->Memory();
  if (pruner_ && pruner_->allocated_bytes() > 0)
    parts.push_back({"rule of pruning", pruner_->allocated_bytes()});
  return parts;
}

}  // namespace cosplat
