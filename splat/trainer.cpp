#include "splat/trainer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "splat/base/error.h"
#include "splat/importance.h"

namespace cosplat {
namespace {

void CheckSize(const TrainFrame& frame, size_t index) {
  const Image8& image = frame.target;
  const Camera& camera = frame.camera;
  if (image.width == camera.width && image.height == camera.height) return;
  const auto text = [](int w, int h) { return std::to_string(w) + "x" + std::to_string(h); };
  throw Error("",
              "training frame " + std::to_string(index),
              "an image of " + text(image.width, image.height) + " pixels for a camera of " +
                  text(camera.width, camera.height));
}

void CheckSomeAreLeft(const Gaussians& gaussians, int iteration) {
  if (gaussians.size() == 0)
    throw Error("", "iteration " + std::to_string(iteration), "every Gaussian was pruned");
}

}  // namespace

Trainer::Trainer(const TrainSettings& settings, Subject& subject, Gaussians first)
    : settings_(settings),
      subject_(subject),
      rasterizer_(MakeCpuRasterizer()),
      tape_(rasterizer_->MakeTape()) {
  if (subject.frame_count() == 0) throw Error("", "training frames", "there is none");
  state_.gaussians = std::move(first);
  state_.adam = AdamState(state_.gaussians);
  state_.statistics.Reset(state_.gaussians.size());
  state_.rng.state = settings.seed;
  HoldOut({});
  pruner_ =
      MakePruner(settings.prune, settings.schedule, settings.iterations, state_.gaussians.size());
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
    for (size_t i = left.size(); i > 1; --i) std::swap(left[i - 1], left[state_.rng.Below(i)]);
  }
  const size_t next = left.back();
  left.pop_back();
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

// Not before all bands are trained: those that are not yet are still zero.
bool Trainer::DropsBandsAt(int iteration) const {
  return settings_.drop_bands > 0 && active_degree() == settings_.degree &&
         BandSchedule::DropsAt(iteration, settings_.iterations);
}

AdamSettings Trainer::RatesAt(int iteration) const {
  const LearningRates& r = settings_.rates;
  AdamSettings adam;
  adam.eps = settings_.eps;
  adam.rate[kPosition] = subject_.extent() * settings_.schedule.PositionRate(
                                                 iteration, r.position_first, r.position_last);
  adam.rate[kRotation] = r.rotation;
  adam.rate[kScaleLog] = r.scale;
  adam.rate[kOpacityLogit] = r.opacity;
  adam.rate[kColorDc] = r.color;
  adam.rate[kColorRest] = r.RestRate();
  return adam;
}

// Adds the regulariser's gradient; returns its value.
double Trainer::RegularizeScale() {
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
void Trainer::FindGroups() {
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
void Trainer::ReleaseScratch() {
  gradients_ = {};
  screen_ = Buffer<float>();
  groups_ = std::vector<uint32_t>();
  tape_ = rasterizer_->MakeTape();
}

Population Trainer::Everyone() {
  return {subject_, state_.gaussians, state_.adam, state_.statistics, pruner_.get()};
}

void Trainer::HoldOut(std::vector<uint32_t> frames) {
  std::sort(frames.begin(), frames.end());
  frames_.clear();
  for (uint32_t f = 0; f < subject_.frame_count(); ++f)
    if (!std::binary_search(frames.begin(), frames.end(), f)) frames_.push_back(f);
  if (frames_.empty()) throw Error("", "training frames", "none is left beside those held out");
  state_.frames_left.clear();
}

double Trainer::PsnrOf(View<const uint32_t> frames) {
  return MeanPsnrOfFrames(
      subject_, frames, CaughtUp(), active_degree(), MeanBackground(), frames.size());
}

int Trainer::FirstPruneStep() const {
  for (int i = 1; i <= settings_.iterations; ++i)
    if (PrunesAt(i)) return i;
  return 0;
}

void Trainer::Restore(const Checkpoint& checkpoint, const PruneSettings& prune) {
  state_ = checkpoint.state;
  subject_.RestoreState(checkpoint.subject);
  ignored_gradients_ = checkpoint.ignored_gradients;
  drop_psnr_ = checkpoint.drop_psnr;
  settings_.prune = prune;
  pruner_ = MakePruner(prune, settings_.schedule, settings_.iterations, state_.gaussians.size());
  ReleaseScratch();
}

// What the rule ranks lowest, and what the cap of groups takes.
PruneRound Trainer::Rank(int iteration) {
  const DensityStatistics& statistics = state_.statistics;
  if (PrunesAt(iteration)) {
    return pruner_->Rank({iteration,
                          subject_,
                          frames_,
                          state_.gaussians,
                          statistics,
                          active_degree(),
                          MeanBackground(),
                          state_.rng});
  }
  PruneRound round;
  for (size_t i = 0; i < state_.gaussians.size(); ++i) {
    round.score.push_back(statistics.MeanPlasticity(i));
    round.exempt.push_back(!(statistics.visible[i] > 0));
  }
  return round;
}

void Trainer::ControlDensityAt(int iteration) {
  const Schedule& schedule = settings_.schedule;
  const bool densifies = schedule.DensifiesAt(iteration);
  const bool prunes = PrunesAt(iteration);
  const bool resets = schedule.ResetsOpacityAt(iteration);
  const bool drops = DropsBandsAt(iteration);
  if (densifies || prunes || resets || drops || iteration == settings_.iterations)
    AdamCatchUpAll(
        RatesAt(iteration - 1), subject_.PositionRateScale(), state_.gaussians, state_.adam);
  if (densifies || prunes) ReleaseScratch();
  if (densifies) {
    if (pruner_) pruner_->BeforeDensification();
    ControlDensity(
        settings_.density, iteration > schedule.size_prune_after, Everyone(), state_.rng);
    CheckSomeAreLeft(state_.gaussians, iteration);
  }
  if (densifies || prunes) {
    if (settings_.prune.group_cap > 0 || prunes)
      Everyone().Prune(Rank(iteration), settings_.prune.group_cap, settings_.prune.group_floor);
    CheckSomeAreLeft(state_.gaussians, iteration);
    SortInSpace(Everyone());
    state_.statistics.Reset(state_.gaussians.size());
  }
  if (resets) ResetOpacity(state_.gaussians, state_.adam);
  if (drops)
    drop_psnr_ += DropBandsInTraining(
        settings_.drop_bands, subject_, frames_, MeanBackground(), state_.gaussians, state_.adam);
}

double Trainer::Forward(size_t index) {
  const TrainFrame& frame = subject_.frame(index);
  const RenderSettings render{NextBackground(), active_degree(), settings_.exp_degree};
  {
    ScopedPhase phase(times_, Phase::kData);
    if (gradients_.size() != state_.gaussians.size()) gradients_ = state_.gaussians.ZerosLike();
  }
  {
    ScopedPhase phase(times_, Phase::kPose);
    world_ = subject_.Place(state_.gaussians, index);
    if (pruner_) pruner_->BeforeDraw(state_.gaussians, world_, state_.rng);
  }
  rasterizer_->Forward(world_, state_.gaussians.basis, frame.camera, render, image_, *tape_);
  ScopedPhase phase(times_, Phase::kLoss);
  return loss_.Evaluate(settings_.loss, image_.color, frame.target, render.background, d_color_);
}

double Trainer::Backward(int iteration) {
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
  if (iteration < settings_.schedule.densify_until)
    state_.statistics.Accumulate(*tape_,
                                 screen_,
                                 gradients_.values[kScaleLog],
                                 state_.gaussians.values[kScaleLog],
                                 image_.width,
                                 image_.height);
  if (!pruner_) return 0;
  return pruner_->AfterBackward(state_.gaussians, gradients_, tape_->radii());
}

void Trainer::Update(int iteration) {
  {
    ScopedPhase phase(times_, Phase::kAdam);
    FindGroups();
    ignored_gradients_ += AdamStepAll(RatesAt(state_.iteration),
                                      gradients_,
                                      subject_.PositionRateScale(),
                                      groups_,
                                      state_.gaussians,
                                      state_.adam);
  }
  ScopedPhase phase(times_, Phase::kDensity);
  state_.iteration = iteration;
  ControlDensityAt(iteration);
  subject_.AfterStep(iteration, state_.gaussians, state_.adam);
}

StepReport Trainer::Step() {
  const auto start = std::chrono::steady_clock::now();
  const double cpu_start = ProcessorSeconds();
  const int iteration = state_.iteration + 1;
  const size_t index = NextFrame();
  CheckSize(subject_.frame(index), index);
  double loss = Forward(index);
  if (!std::isfinite(loss))
    throw Error("", "iteration " + std::to_string(iteration), "the loss is not finite");
  loss += Backward(iteration);
  loss += RegularizeScale();
  Update(iteration);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  seconds_ += seconds;
  cpu_seconds_ += ProcessorSeconds() - cpu_start;
  last_seconds_[steps_++ % last_seconds_.size()] = seconds;
  return {iteration, loss, state_.gaussians.size()};
}

Gaussians Trainer::CaughtUp() const {
  Gaussians gaussians = state_.gaussians;
  AdamState adam = state_.adam;
  const AdamSettings rates = RatesAt(std::max(state_.iteration - 1, 0));
  AdamCatchUpAll(rates, subject_.PositionRateScale(), gaussians, adam);
  return gaussians;
}

TrainingStatistics Trainer::statistics() const {
  TrainingStatistics s;
  s.iterations = state_.iteration;
  s.steps = steps_;
  s.seconds = seconds_;
  s.cpu_seconds = cpu_seconds_;
  s.gaussians = state_.gaussians.size();
  s.times = times_;
  s.times += rasterizer_->times;
  s.ignored_gradients = ignored_gradients_;
  s.degrees = CountDegrees(state_.gaussians);
  s.bands = FiguresOf(s.degrees, state_.gaussians.degree);
  s.drop_psnr = drop_psnr_;
  const size_t count = std::min(steps_, last_seconds_.size());
  if (count == 0) return s;
  auto last = last_seconds_;
  std::nth_element(last.begin(), last.begin() + count / 2, last.begin() + count);
  s.ms_per_step = 1e3 * last[count / 2];
  return s;
}

std::vector<MemoryPart> Trainer::Memory() const {
  const DensityStatistics& d = state_.statistics;
  std::vector<MemoryPart> parts{
      {"parameters", HeldBy(state_.gaussians)},
      {"gradients", HeldBy(gradients_)},
      {"first moments", HeldBy(state_.adam.m)},
      {"second moments", HeldBy(state_.adam.v)},
      {"groups of Adam", HeldBy(state_.adam.updated, groups_, needles_)},
      {"density statistics", HeldBy(d.screen_gradient, d.plasticity, d.visible, d.max_radius)},
      {"screen gradients", HeldBy(screen_)},
      {"picture and its gradient",
       HeldBy(image_.color, image_.transmittance, d_color_),
       MemoryOf::kPixels}};
  if (pruner_ && pruner_->Held() > 0) parts.push_back({"rule of pruning", pruner_->Held()});
  for (MemoryPart& part : tape_->Memory()) parts.push_back(std::move(part));
  return parts;
}

}  // namespace cosplat
