#include "apps/cosplat/run/block_training.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "apps/cosplat/run/block_files.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/stop_signals.h"
#include "apps/cosplat/run/test_images.h"
#include "apps/cosplat/run/train_run.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/ply.h"
#include "splat/train/blocks.h"
#include "splat/train/describe_state.h"
#include "splat/train/layers.h"

namespace cosplat {
namespace {

// Of a run's steps, those on the whole scene: until its images have their full size.
constexpr double kWholeShare = 0.2;
// How often each block has its turn (measured: docs/decisions.md).
constexpr size_t kRounds = 2;
// A block trains on the views of which it covers at least this share, or this part of its largest
// share if that is less: so early, a block may be hardly opaque.
constexpr float kLeastShare = 0.01f;
constexpr float kLeastPart = 0.25f;

Gaussians LayoutOf(const Gaussians& gaussians) {
  Gaussians layout;
  layout.degree = gaussians.degree;
  layout.basis = gaussians.basis;
  layout.antialiased = gaussians.antialiased;
  return layout;
}

// What was trained before, added up.
struct Trained {
  uint64_t steps = 0, ignored = 0;
  double seconds = 0, cpu_seconds = 0, ms_per_step = 0;
  PhaseTimes times;
};

class BlockTraining {
 public:
  BlockTraining(const SceneTrainOptions& o,
                const TrainSettings& whole,
                const Gaussians& layout,
                SceneSubject& scene,
                RunCheckpoint& checkpoint)
      : o_(o),
        whole_(whole),
        files_(o.model, layout),
        scene_(scene),
        checkpoint_(checkpoint),
        views_(o.blocks),
        counts_(o.blocks, 0),
        shown_(o.blocks * scene.frame_count(), 0) {}

  void Run(Gaussians first) {
    BlockFiles::Make(o_.model);
    if (checkpoint_.resumes())
      Resume(std::move(first));
    else
      BeginStage(std::move(first));
    while (true) {
      TrainStage();
      FinishStage();
      if (stage_ == LastStage()) break;
      ++stage_;
      BeginStage(files_.ReadBlock(block()));
    }
    bar_.reset();
  }

  size_t count() const { return std::accumulate(counts_.begin(), counts_.end(), size_t(0)); }
  // A block as it is saved, if it can be.
  Gaussians Finished(size_t b) const {
    Gaussians own = files_.ReadBlock(b);
    BakeSmoothing(own);
    if (IsHarmonic(own.basis, own.degree)) ConvertBasis(own, Basis::kSh);
    return own;
  }
  Gaussians Together() const {
    Gaussians all;
    for (size_t b = 0; b < o_.blocks; ++b) {
      const Gaussians own = Finished(b);
      if (b == 0) all = LayoutOf(own);
      for (int a = 0; a < kAttributeCount; ++a) {
        all.values[a].reserve(count() * size_t(own.width(a)));
        all.values[a].append(own.values[a].begin(), own.values[a].end());
      }
    }
    return all;
  }

  const ExposureState& exposures() const { return exposures_; }

  TrainingStatistics Statistics() const {
    TrainingStatistics s;
    s.iterations = o_.iterations;
    s.steps = trained_.steps;
    s.seconds = trained_.seconds;
    s.cpu_seconds = trained_.cpu_seconds;
    s.gaussians = count();
    s.ms_per_step = trained_.ms_per_step;
    s.times = trained_.times;
    s.ignored_gradients = trained_.ignored;
    s.degrees[size_t(o_.sh_degree)] = count();
    s.bands = FiguresOf(s.degrees, o_.sh_degree);
    return s;
  }

  Json Figures() const {
    Json blocks = Json::array();
    for (size_t b = 0; b < o_.blocks; ++b)
      blocks.push_back({{"gaussians", counts_[b]},
                        {"views", views_[b].size()},
                        {"iterations", IterationsOf(b)}});
    return blocks;
  }

  void StopIfAsked() {
    if (const int signal = signals_.received())
      throw Stopped(signal, "stopped between steps: the same command with --resume goes on");
  }

 private:
  // Stage 0 is the whole scene's; then all blocks have their turns.
  bool whole() const { return stage_ == 0; }
  size_t block() const { return (stage_ - 1) % o_.blocks; }
  size_t round() const { return (stage_ - 1) / o_.blocks; }
  uint32_t LastStage() const { return uint32_t(kRounds * o_.blocks); }

  // --- Steps -------------------------------------------------------------------------------------

  // As many passes over its views as the whole scene would make over all.
  int IterationsOf(size_t b) const {
    const double share = double(views_[b].size()) / double(scene_.frame_count());
    return std::max(1, int(std::ceil(o_.iterations * share)));
  }
  // Of a training of that length, where a round begins, which is a multiple of the batch.
  int BeginOf(int iterations, size_t round) const {
    if (round == kRounds) return iterations;
    const double share = kWholeShare + (1 - kWholeShare) * double(round) / kRounds;
    const int steps = int(std::ceil(iterations * share / o_.batch));
    return std::min(iterations, steps * o_.batch);
  }
  TrainSettings SettingsOfStage() const {
    TrainOptions options = o_;
    if (!whole()) options.iterations = IterationsOf(block());
    TrainSettings s = options.ToSettings(scene_.extent());
    s.crop_loss.distance = whole_.crop_loss.distance;
    s.schedule.opacity_reset_share = whole_.schedule.opacity_reset_share;
    if (whole()) {
      s.iterations = BeginOf(o_.iterations, 0);
      return s;
    }
    s.first_iteration = BeginOf(options.iterations, round());
    s.iterations = BeginOf(options.iterations, round() + 1);
    s.seed = o_.seed + stage_ * 0x9e3779b97f4a7c15u;  // Rng's own increment
    s.schedule.num_downscales = 0;                    // layers are of the full size
    return s;
  }
  // Steps of all turns before this one, and of all.
  int StepsBefore(uint32_t stage) const {
    int steps = 0;
    for (uint32_t s = 1; s < stage; ++s) {
      const int all = IterationsOf((s - 1) % o_.blocks);
      const size_t r = (s - 1) / o_.blocks;
      steps += BeginOf(all, r + 1) - BeginOf(all, r);
    }
    return steps;
  }
  int StepsDone() const {
    return StepsBefore(stage_) + trainer_->iteration() - trainer_->settings().first_iteration;
  }
  // For messages, in steps of the run.
  int Iteration() const {
    if (whole()) return trainer_->iteration();
    const int first = BeginOf(o_.iterations, 0);
    const double share = double(StepsDone()) / double(StepsBefore(LastStage() + 1));
    return first + int((o_.iterations - first) * share);
  }

  // --- Stages ------------------------------------------------------------------------------------

  void BeginStage(Gaussians first) {
    if (!whole()) MakeBlockSubject();
    trainer_ = std::make_unique<Trainer>(
        SettingsOfStage(), whole() ? scene_ : *block_subject_, std::move(first));
    if (o_.exposure && !whole()) trainer_->SetExposures(OwnExposures());
    line_ = LossLine();
  }

  void TrainStage() {
    const bool blocks = !whole();
    if (!bar_ || stage_ == 1) {
      bar_.reset();  // terminates its line
      bar_ = std::make_unique<ProgressBar>(
          blocks ? "blocks" : "whole scene",
          blocks ? StepsBefore(LastStage() + 1) : trainer_->settings().iterations,
          o_.quiet,
          OffTerminal::kLines,
          blocks ? StepsDone() : trainer_->iteration());
    }
    while (trainer_->iteration() < trainer_->settings().iterations) {
      const StepReport step = trainer_->Step();
      if (blocks)
        bar_->Update(StepsDone(),
                     "block " + std::to_string(block() + 1) + " of " + std::to_string(o_.blocks) +
                         "  " + line_(step));
      else
        bar_->Update(step.iteration, line_(step));
      if (const int signal = signals_.received()) Stop(signal);
      if (checkpoint_.IsDue()) checkpoint_.TryToWrite(Iteration(), Description());
    }
    // Before the files of the block change, which an earlier one would go on with.
    checkpoint_.Write(Iteration(), Description());
  }

  void FinishStage() {
    const TrainingStatistics s = trainer_->statistics();
    trained_.steps += s.steps;
    trained_.ignored += s.ignored_gradients;
    trained_.seconds += s.seconds;
    trained_.cpu_seconds += s.cpu_seconds;
    trained_.ms_per_step = s.ms_per_step;
    trained_.times += s.times;
    const TrainingState& state = trainer_->state();
    KeepExposures(state.exposures);
    if (whole()) {
      files_.WriteWhole(state.gaussians);
    } else {
      files_.WriteBlock(block(), state.gaussians);
      counts_[block()] = state.gaussians.size();
    }
    // Its memory is needed for what follows.
    trainer_.reset();
    block_subject_.reset();
    if (whole()) {
      Split(files_.ReadWhole());
      files_.RemoveWhole();
      for (size_t b = 0; b < o_.blocks; ++b) DrawLayers(b);
      ChooseViews();
      if (!o_.quiet) PrintSplit();
    } else if (stage_ != LastStage()) {
      DrawLayers(block());
    }
  }

  void Split(const Gaussians& all) {
    blocks_ = SplitByPlace(all.values[kPosition].view(), o_.blocks);
    std::vector<std::vector<uint32_t>> of(o_.blocks);
    for (size_t i = 0; i < all.size(); ++i)
      of[blocks_.BlockOf(all.at(kPosition, i))].push_back(uint32_t(i));
    for (size_t b = 0; b < o_.blocks; ++b) {
      Gaussians own = all;
      own.Gather(of[b]);
      files_.WriteBlock(b, own);
      counts_[b] = own.size();
    }
  }

  void ChooseViews() {
    const size_t count = scene_.frame_count();
    std::vector<float> share(o_.blocks * count), largest(o_.blocks, 0.0f);
    for (size_t v = 0; v < count; ++v) {
      LayerStack stack;
      for (const uint32_t b : OrderIn(v)) {
        share[b * count + v] = stack.Add(ReadLayer(b, v));
        largest[b] = std::max(largest[b], share[b * count + v]);
      }
    }
    for (size_t b = 0; b < o_.blocks; ++b) {
      const float least = std::min(kLeastShare, kLeastPart * largest[b]);
      for (size_t v = 0; v < count; ++v)
        if (share[b * count + v] >= least) views_[b].push_back(uint32_t(v));
    }
  }

  void PrintSplit() {
    bar_.reset();
    for (size_t b = 0; b < o_.blocks; ++b)
      std::printf("block %zu: %s Gaussians, %zu of %zu views\n",
                  b + 1,
                  WithThousands(counts_[b]).c_str(),
                  views_[b].size(),
                  scene_.frame_count());
    std::fflush(stdout);
  }

  // --- Layers ------------------------------------------------------------------------------------

  std::vector<uint32_t> OrderIn(size_t view) const {
    return blocks_.FrontToBack(scene_.camera(view).Center());
  }
  Image8 ReadLayer(size_t b, size_t view) const {
    if (!shown_[b * scene_.frame_count() + view]) return {};
    return files_.ReadLayer(b, view, scene_.camera(view));
  }

  void DrawLayers(size_t b) {
    const Gaussians gaussians = files_.ReadBlock(b);
    const auto rasterizer = MakeCpuRasterizer();
    const auto tape = rasterizer->MakeTape(false);
    RenderedImage image;
    for (size_t v = 0; v < scene_.frame_count(); ++v) {
      StopIfAsked();
      rasterizer->Forward(ViewOf(gaussians),
                          gaussians.basis,
                          scene_.camera(v),
                          {{0, 0, 0}, gaussians.degree},
                          image,
                          *tape);
      const Image8 layer = LayerOf(image);
      shown_[b * scene_.frame_count() + v] = !layer.empty();
      if (!layer.empty()) files_.WriteLayer(b, v, layer);
    }
  }

  void MakeBlockSubject() {
    std::vector<TrainFrame> frames;
    for (const uint32_t view : views_[block()]) {
      const auto read = [this, view, b = uint32_t(block())] {
        TrainFrame scratch;
        const TrainFrame& frame = Loaded(scene_.frames()[view], scratch);
        TrainFrame shown{frame.camera, frame.target, frame.ignored};
        LayerStack stack;
        for (const uint32_t other : OrderIn(view)) {
          if (other == b)
            shown.layers.front = std::exchange(stack, {}).Together();
          else
            stack.Add(ReadLayer(other, view));
        }
        shown.layers.behind = stack.Together();
        return shown;
      };
      frames.push_back({scene_.camera(view), {}, {}, read});
    }
    block_subject_.emplace(std::move(frames), scene_.extent());
  }

  // --- Exposures of a block's views, of those of all ---------------------------------------------

  template <class Copy>
  void ForOwnExposures(const Copy& copy) const {
    constexpr size_t kNumbers = kIdentityExposure.size();
    for (size_t i = 0; i < views_[block()].size(); ++i)
      for (size_t k = 0; k < kNumbers; ++k)
        copy(i * kNumbers + k, views_[block()][i] * kNumbers + k);
  }
  ExposureState OwnExposures() const {
    ExposureState own(views_[block()].size());
    ForOwnExposures([&](size_t to, size_t from) {
      own.value[to] = exposures_.value[from];
      own.m[to] = exposures_.m[from];
      own.v[to] = exposures_.v[from];
      own.updates[to] = exposures_.updates[from];
    });
    return own;
  }
  void KeepExposures(const ExposureState& own) {
    if (whole()) {
      exposures_ = own;
    } else if (o_.exposure) {
      ForOwnExposures([&](size_t from, size_t to) {
        exposures_.value[to] = own.value[from];
        exposures_.m[to] = own.m[from];
        exposures_.v[to] = own.v[from];
        exposures_.updates[to] = own.updates[from];
      });
    }
  }

  // --- Checkpoints -------------------------------------------------------------------------------

  void DescribeOwn(StateArchive& a) {
    a.Value("stage", stage_);
    a.Require(stage_ <= LastStage(), "stage", "is beyond the run's end");
    a.Value("trained", trained_);
    if (whole()) return;
    const size_t views = scene_.frame_count();
    Describe(a, o_.blocks, blocks_);
    for (size_t b = 0; b < o_.blocks; ++b) {
      a.ArrayUpTo("views", views_[b], views);
      for (const uint32_t view : views_[b])
        a.Require(view < views, "views", "names one that is not there");
    }
    a.Array("counts", counts_, o_.blocks);
    a.Array("shown", shown_, shown_.size());
    if (!o_.exposure) return;
    const size_t numbers = views * kIdentityExposure.size();
    a.Array("exposures.value", exposures_.value, numbers);
    a.Array("exposures.m", exposures_.m, numbers);
    a.Array("exposures.v", exposures_.v, numbers);
    a.Array("exposures.updates", exposures_.updates, numbers);
  }

  StateDescription Description() {
    return [this](StateArchive& a) {
      DescribeOwn(a);
      trainer_->Describe(a);
    };
  }

  void Resume(Gaussians first) {
    checkpoint_.Read([&](StateArchive& a) {
      DescribeOwn(a);
      BeginStage(whole() ? std::move(first) : files_.ReadBlock(block()));
      trainer_->Describe(a);
    });
    if (o_.quiet) return;
    std::printf("resumed at step %s of %s\n",
                WithThousands(size_t(Iteration())).c_str(),
                WithThousands(size_t(o_.iterations)).c_str());
    std::fflush(stdout);
  }

  void Stop(int signal) {
    try {
      checkpoint_.Write(Iteration(), Description());
    } catch (const Error& error) {
      throw Stopped(signal, std::string("stopped, without a checkpoint: ") + error.what());
    }
    throw Stopped(signal,
                  "stopped at step " + WithThousands(size_t(Iteration())) +
                      ": the same command with --resume goes on");
  }

  const SceneTrainOptions& o_;
  const TrainSettings& whole_;
  BlockFiles files_;
  SceneSubject& scene_;
  RunCheckpoint& checkpoint_;
  // What a checkpoint has, besides the trainer.
  uint32_t stage_ = 0;
  Trained trained_;
  SceneBlocks blocks_;
  std::vector<std::vector<uint32_t>> views_;  // of each block
  std::vector<uint64_t> counts_;              // Gaussians of each block
  std::vector<uint8_t> shown_;                // [blocks, views] whether it has a layer
  ExposureState exposures_;                   // of all views; empty unless trained
  // This stage's.
  std::optional<SceneSubject> block_subject_;
  std::unique_ptr<Trainer> trainer_;
  std::unique_ptr<ProgressBar> bar_;
  LossLine line_;
  StopSignals signals_;
};

}  // namespace

void TrainInBlocks(const SceneTrainOptions& o,
                   SceneStart start,
                   SceneSubject& scene,
                   const std::vector<SkippedFrame>& skipped,
                   const BlockHooks& hooks,
                   RunCheckpoint& checkpoint) {
  RemoveTemporaries(o.model);
  WriteSkipped(o.model, skipped);
  Gaussians layout = LayoutOf(start.first);
  layout.antialiased = o.antialiasing;
  BlockTraining training(o, start.settings, layout, scene, checkpoint);
  training.Run(std::move(start.first));
  if (CanSaveSplats(o))
    WritePly(MakeSplatPath(o.model, o.iterations), training.count(), o.blocks, [&](size_t block) {
      return training.Finished(block);
    });
  if (o.exposure) hooks.save_exposures(training.exposures());
  const TrainingStatistics statistics = training.Statistics();
  WriteStatistics(o.model, statistics, skipped.size(), training.Figures());
  if (!o.quiet) PrintTrained(statistics);
  training.StopIfAsked();
  if (!hooks.evaluate) return;
  hooks.evaluate(training.Together());
  const TestSummary summary = EvaluateTestImages(o.model, o.iterations, hooks.lpips);
  if (!o.quiet) std::printf("%s\n", ToString(summary).c_str());
  training.StopIfAsked();
}

}  // namespace cosplat
