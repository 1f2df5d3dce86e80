#include "apps/cosplat/run/block_training.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "apps/cosplat/run/block_files.h"
#include "apps/cosplat/run/block_layers.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/stop_signals.h"
#include "apps/cosplat/run/train_run.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/io/ply.h"
#include "splat/train/blocks/block_schedule.h"
#include "splat/train/blocks/blocks.h"
#include "splat/train/serialize_state.h"

namespace cosplat {
namespace {

Gaussians LayoutOf(const Gaussians& gaussians) {
  Gaussians layout;
  layout.degree = gaussians.degree;
  layout.basis = gaussians.basis;
  layout.antialiased = gaussians.antialiased;
  layout.origin = gaussians.origin;
  return layout;
}

RoundCost CostOf(const TrainingStatistics& s) {
  return {s.steps, s.ignored_gradients, s.seconds, s.cpu_seconds, s.ms_per_step, s.times};
}

// One rank's part in it. All ranks go through the same rounds, and meet at their ends; in between
// each works on the blocks of its group, whose first rank writes their files.
class BlockTraining {
 public:
  BlockTraining(const SceneTrainOptions& o,
                const TrainSettings& whole,
                const Gaussians& layout,
                SceneSubject& scene,
                RunCheckpoint& checkpoint,
                Ranks& ranks)
      : o_(o),
        whole_(whole),
        files_(o.model, layout),
        scene_(scene),
        state_(o.blocks),
        layers_(files_, scene, state_.blocks),
        checkpoint_(checkpoint),
        ranks_(ranks),
        // A step of the whole scene has work for as many ranks as it has views.
        group_(ranks.Part(TrainsWhole() ? 0 : ranks.rank())) {}

  void Run(Gaussians first) {
    if (writes()) BlockFiles::Make(o_.model);
    const int reached = checkpoint_.resumes() ? Resume(first) : 0;
    if (checkpoint_.resumes()) PrintResumed(o_, reached);
    if (state_.round == 0) {
      if (TrainsWhole()) TrainWhole(std::move(first));
      ReleaseTrainer();
      Meet();
      Split();
    }
    first = {};  // its memory is needed for blocks
    ShareOut();
    if (state_.round == 0) BeginRound();
    bar_.reset();  // terminates its line
    bar_ = std::make_unique<ProgressBar>(
        "blocks", StepsBefore(kBlockRounds + 1, 0), o_.quiet, OffTerminal::kLines, StepsDone());
    while (true) {
      for (const uint32_t b : OwnBlocks())
        if (files_.ReadRecord(b).round < state_.round) TrainBlock(b);
      Meet();
      FinishRound();
      if (state_.round == kBlockRounds) break;
      DrawLayers();
      Meet();
      BeginRound();
    }
    bar_.reset();
  }

  size_t count() const {
    return std::accumulate(state_.counts.begin(), state_.counts.end(), size_t(0));
  }
  // Blocks as they are saved, if they can be.
  Gaussians Finished(const std::vector<uint32_t>& blocks) const {
    Gaussians gaussians = files_.ReadBlocks(blocks);
    BakeSmoothing(gaussians);
    if (IsHarmonic(gaussians.basis, gaussians.degree)) ConvertBasis(gaussians, Basis::kSh);
    return gaussians;
  }
  Gaussians Together() const {
    std::vector<uint32_t> all(o_.blocks);
    std::iota(all.begin(), all.end(), 0u);
    return Finished(all);
  }

  const ExposureState& exposures() const { return state_.exposures; }

  TrainingStatistics Statistics() const {
    TrainingStatistics s;
    s.iterations = o_.iterations;
    s.steps = state_.cost.steps;
    s.seconds = state_.cost.seconds;
    s.cpu_seconds = state_.cost.cpu_seconds;
    s.gaussians = count();
    s.ms_per_step = state_.cost.ms_per_step;
    s.times = state_.cost.times;
    s.ignored_gradients = state_.cost.ignored;
    s.degrees[size_t(o_.sh_degree)] = count();
    s.bands = FiguresOf(s.degrees, o_.sh_degree);
    return s;
  }

  Json Figures() const {
    Json blocks = Json::array();
    for (size_t b = 0; b < o_.blocks; ++b)
      blocks.push_back({{"gaussians", state_.counts[b]},
                        {"views", state_.views[b].size()},
                        {"iterations", IterationsOf(b)}});
    return blocks;
  }

  void Meet() { Meet(ranks_); }

 private:
  // All of these ranks get here, and stop if one of them was asked to.
  void Meet(Ranks& ranks) {
    if (const uint32_t signal = Largest(uint32_t(signals_.received()), ranks))
      throw Stopped(int(signal), "stopped between steps: the same command with --resume goes on");
  }
  bool IsAsked() const { return signals_.received() != 0; }

  // Round 0 is the whole scene's.
  bool whole() const { return state_.round == 0; }
  bool writes() const { return ranks_.rank() == 0; }
  bool TrainsWhole() const { return ranks_.rank() < size_t(o_.batch); }
  bool leads() const { return group_->rank() == 0; }
  std::vector<uint32_t> OwnBlocks() const {
    std::vector<uint32_t> own;
    for (uint32_t b = 0; b < o_.blocks; ++b)
      if (groups_.OfBlock(b) == groups_.GroupOf(ranks_.rank())) own.push_back(b);
    return own;
  }

  // --- Steps -------------------------------------------------------------------------------------

  double ShareOfViews(size_t b) const {
    return double(state_.views[b].size()) / double(scene_.frame_count());
  }
  // As many passes over its views as the whole scene would make over all.
  int IterationsOf(size_t b) const {
    return std::max(1, int(std::ceil(o_.iterations * ShareOfViews(b))));
  }
  int EndOf(uint32_t round, size_t b) const {
    return EndOfBlockRound(round, IterationsOf(b), o_.batch);
  }
  TrainSettings SettingsOfRound() const {
    TrainSettings s = o_.ToSettings(scene_.extent());
    s.crop_loss.distance = whole_.crop_loss.distance;
    s.schedule.opacity_reset_share = whole_.schedule.opacity_reset_share;
    const int iterations = whole() ? o_.iterations : IterationsOf(block_);
    s.iterations = EndOfBlockRound(state_.round, iterations, o_.batch);
    if (whole()) return s;
    s.schedule = s.schedule.OfPart(ShareOfViews(block_));
    s.first_iteration = EndOf(state_.round - 1, block_);
    const uint64_t trained = (state_.round - 1) * o_.blocks + block_ + 1;
    s.seed = o_.seed + trained * 0x9e3779b97f4a7c15u;  // Rng's own increment
    s.schedule.num_downscales = 0;                     // layers are of the full size
    return s;
  }
  // Steps of this group before it trains block b in a round.
  int StepsBefore(uint32_t round, size_t b) const {
    int steps = 0;
    for (uint32_t r = 1; r <= std::min(round, kBlockRounds); ++r)
      for (const uint32_t own : OwnBlocks())
        if (r < round || own < b) steps += EndOf(r, own) - EndOf(r - 1, own);
    return steps;
  }
  int StepsDone() const {
    if (!trainer_) return StepsBefore(state_.round, 0);
    return StepsBefore(state_.round, block_) + trainer_->iteration() -
           trainer_->settings().first_iteration;
  }
  // For messages, in steps of the run, of which this group has had a share.
  int Iteration() const {
    if (whole()) return trainer_->iteration();
    const int first = EndOfBlockRound(0, o_.iterations, o_.batch);
    const int all = std::max(1, StepsBefore(kBlockRounds + 1, 0));
    return first + int((o_.iterations - first) * (double(StepsDone()) / all));
  }

  // Steps of trainer_ to its end, and a checkpoint of that, since an earlier one would go on with
  // files that change now.
  void TakeSteps(const std::function<void(const StepReport&)>& show) {
    while (trainer_->iteration() < trainer_->settings().iterations) {
      show(trainer_->Step());
      const Agreement agreed = AgreeAfterStep(signals_.received(), checkpoint_, *group_);
      if (agreed.signal != 0)
        StopWithCheckpoint(agreed.signal, Iteration(), [&] { WriteCheckpoint(); });
      if (!agreed.checkpoint) continue;
      checkpoint_.Try([&] { WriteCheckpoint(); });
    }
    WriteCheckpoint();
  }

  // --- Rounds ------------------------------------------------------------------------------------

  void MakeTrainer(Gaussians first) {
    trainer_ = std::make_unique<Trainer>(SettingsOfRound(),
                                         whole() ? scene_ : *block_subject_,
                                         std::move(first),
                                         HostStepEngineOn(group_));
    line_ = LossLine();
  }
  // Its memory is needed for what follows.
  void ReleaseTrainer() {
    trainer_.reset();
    block_subject_.reset();
  }

  void TrainWhole(Gaussians first) {
    if (!trainer_) MakeTrainer(std::move(first));
    bar_ = std::make_unique<ProgressBar>("whole scene",
                                         trainer_->settings().iterations,
                                         o_.quiet,
                                         OffTerminal::kLines,
                                         trainer_->iteration());
    TakeSteps([&](const StepReport& step) { bar_->Update(step.iteration, line_(step)); });
    const RoundCost cost = CostOf(trainer_->statistics());
    const Gaussians trained = trainer_->TakeGaussians();
    if (leads())
      files_.WriteBlock(
          kWholeScene, trained, {0, trained.size(), cost, trainer_->state().exposures});
  }

  void TrainBlock(uint32_t b) {
    block_ = b;
    ExposureState exposures;
    if (o_.exposure) exposures = state_.exposures.Of(state_.views[b]);
    layers_.PutTogether(b, state_.views[b], exposures, group_->rank(), group_->size(), [this] {
      return !IsAsked();
    });
    Meet(*group_);
    // The first of them says whether there is a checkpoint, since a network's file system may show
    // it to the others later.
    const std::string path = files_.CheckpointPath(b, state_.round);
    const bool resumes = Largest(leads() && std::filesystem::exists(path) ? 1 : 0, *group_) != 0;
    block_subject_.emplace(layers_.FramesOf(b, state_.views[b]), scene_.extent());
    MakeTrainer(files_.ReadBlock(b));
    if (o_.exposure) trainer_->SetExposures(std::move(exposures));
    if (resumes) StateFile(path).Read([&](StateArchive& a) { trainer_->Serialize(a); });
    const std::string title = Format("block {} of {}  ", b + 1, o_.blocks);
    TakeSteps([&](const StepReport& step) { bar_->Update(StepsDone(), title + line_(step)); });
    const RoundCost cost = CostOf(trainer_->statistics());
    const Gaussians trained = trainer_->TakeGaussians();
    if (leads()) {
      layers_.RemoveTogether(b, state_.views[b]);
      files_.WriteBlock(
          b, trained, {state_.round, trained.size(), cost, trainer_->state().exposures});
      RemoveFile(path);
    }
    ReleaseTrainer();
  }

  void Split() {
    SplitWhole();
    Meet();
    DrawLayers();
    Meet();
    state_.views = layers_.ChooseViews();
    if (!o_.quiet) PrintSplit();
  }

  void SplitWhole() {
    BlockRecord record = files_.ReadRecord(kWholeScene);
    const Gaussians all = files_.ReadBlock(kWholeScene);
    state_.cost += record.cost;
    state_.exposures = std::move(record.exposures);
    state_.blocks = SplitByPlace(all.values[kPosition].view(), o_.blocks);
    std::vector<std::vector<uint32_t>> of(o_.blocks);
    for (size_t i = 0; i < all.size(); ++i)
      of[state_.blocks.BlockOf(all.at(kPosition, i))].push_back(uint32_t(i));
    for (size_t b = 0; b < o_.blocks; ++b) {
      state_.counts[b] = of[b].size();
      if (!writes()) continue;
      Gaussians own = all;
      own.Gather(of[b]);
      files_.WriteBlock(b, own, {0, own.size(), {}, {}});
    }
  }

  // From here on group_ is of those that train a block.
  void ShareOut() {
    std::vector<int> work;
    for (size_t b = 0; b < o_.blocks; ++b) work.push_back(IterationsOf(b));
    groups_ = BlockGroups(work, ranks_.size());
    group_ = ranks_.Part(groups_.GroupOf(ranks_.rank()));
    if (!o_.quiet && ranks_.size() > 1) PrintGroups();
  }

  // Until all have got here nobody changes a file that an earlier checkpoint would need.
  void BeginRound() {
    ++state_.round;
    if (writes()) checkpoint_.Write(Iteration(), Description(), *OneRank());
    if (writes() && state_.round == 1) files_.RemoveWhole();
    Meet();
  }

  void FinishRound() {
    const double before = state_.cost.seconds;
    std::vector<double> seconds(groups_.count(), 0);  // which work at the same time
    std::vector<ExposureState> exposures(o_.blocks);
    for (size_t b = 0; b < o_.blocks; ++b) {
      BlockRecord record = files_.ReadRecord(b);
      state_.counts[b] = record.gaussians;
      state_.cost += record.cost;
      seconds[groups_.OfBlock(b)] += record.cost.seconds;
      exposures[b] = std::move(record.exposures);
    }
    state_.cost.seconds = before + *std::max_element(seconds.begin(), seconds.end());
    if (o_.exposure) state_.exposures.SetToMeans(state_.views, exposures);
  }

  // The ranks share the views.
  void DrawLayers() {
    layers_.Draw(ranks_.rank(), ranks_.size(), [this] { return !IsAsked(); });
  }

  void PrintSplit() {
    bar_.reset();
    for (size_t b = 0; b < o_.blocks; ++b)
      std::printf("block %zu: %s Gaussians, %zu of %zu views\n",
                  b + 1,
                  WithThousands(state_.counts[b]).c_str(),
                  state_.views[b].size(),
                  scene_.frame_count());
    std::fflush(stdout);
  }

  void PrintGroups() const {
    std::printf("blocks are shared by %zu groups of ranks\n", groups_.count());
    std::fflush(stdout);
  }

  // --- Checkpoints -------------------------------------------------------------------------------

  // The run's own has the whole scene's trainer or, later, what all blocks have in common; each
  // block in training has another, written by its group.
  void SerializeCommon(StateArchive& a) { state_.Serialize(a, scene_.frame_count(), o_.exposure); }

  StateDescription Description() {
    return [this](StateArchive& a) {
      SerializeCommon(a);
      if (whole()) trainer_->Serialize(a);
    };
  }

  // All ranks of the group call it: each has a part of the state.
  void WriteCheckpoint() {
    if (whole()) return checkpoint_.Write(Iteration(), Description(), *group_);
    checkpoint_.WritePart(
        files_.CheckpointPath(block_, state_.round),
        [this](StateArchive& a) { trainer_->Serialize(a); },
        *group_);
    if (writes()) checkpoint_.Write(Iteration(), Description(), *OneRank());  // how far the run is
  }

  // Returns the iteration that the run had reached.
  int Resume(Gaussians& first) {
    return checkpoint_.Read([&](StateArchive& a) {
      SerializeCommon(a);
      if (!whole()) return;
      MakeTrainer(std::move(first));
      trainer_->Serialize(a);
    });
  }

  const SceneTrainOptions& o_;
  const TrainSettings& whole_;
  BlockFiles files_;
  SceneSubject& scene_;
  BlockState state_;  // alike on all ranks
  BlockLayers layers_;
  RunCheckpoint& checkpoint_;
  Ranks& ranks_;
  std::shared_ptr<Ranks> group_;  // those that train what this rank trains
  BlockGroups groups_;
  // This rank's.
  uint32_t block_ = 0;  // in training
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
                   RunCheckpoint& checkpoint,
                   Ranks& ranks) {
  const bool writes = ranks.rank() == 0;
  if (writes) RemoveTemporaries(o.model);
  if (writes) WriteSkipped(o.model, skipped);
  Gaussians layout = LayoutOf(start.first);
  layout.antialiased = o.antialiasing;
  BlockTraining training(o, start.settings, layout, scene, checkpoint, ranks);
  training.Run(std::move(start.first));
  if (writes) {
    if (CanSaveSplats(o))
      WritePly(MakeSplatPath(o.model, o.iterations), training.count(), o.blocks, [&](size_t block) {
        return training.Finished({uint32_t(block)});
      });
    if (o.exposure) hooks.save_exposures(training.exposures());
    const TrainingStatistics statistics = training.Statistics();
    WriteStatistics(o.model, statistics, skipped.size(), training.Figures());
    if (!o.quiet) PrintTrained(statistics);
    if (hooks.evaluate) hooks.evaluate(training.Together());
  }
  training.Meet();
  if (!hooks.evaluate) return;
  if (writes) PrintEvaluation(o, hooks.lpips);
  training.Meet();
}

}  // namespace cosplat
