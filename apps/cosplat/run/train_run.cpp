#include "apps/cosplat/run/train_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/stop_signals.h"
#include "apps/cosplat/run/test_images.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"
#include "splat/train/budget.h"

namespace cosplat {

void PrintFinished(const TrainOptions& o) {
  if (!o.quiet) std::printf("trained by an earlier run with the same options\n");
}

void PrintSettled(const TrainOptions& o) {
  if (!o.quiet && !o.settled.empty()) std::printf("--quality sets%s\n", o.settled.c_str());
}

std::string LossLine::operator()(const StepReport& step) {
  const bool first = step.iteration == 1 || std::isnan(loss_);  // of a run, or since resuming
  loss_ = first ? step.loss : 0.95 * loss_ + 0.05 * step.loss;
  return Format("loss {:.4f}  {} Gaussians", loss_, WithThousands(step.gaussians));
}

std::shared_ptr<Lpips> LoadLpips(const TrainOptions& o) {
  return o.lpips.empty() ? nullptr : std::make_shared<Lpips>(o.lpips);
}

void PrintResumed(const TrainOptions& o, int iteration) {
  if (o.quiet) return;
  std::printf("resumed at step %s of %s\n",
              WithThousands(size_t(iteration)).c_str(),
              WithThousands(size_t(o.iterations)).c_str());
  std::fflush(stdout);
}

void StopWithCheckpoint(int signal, int iteration, const std::function<void()>& write_checkpoint) {
  try {
    write_checkpoint();
  } catch (const Error& error) {
    throw Stopped(signal, std::string("stopped, without a checkpoint: ") + error.what());
  }
  throw Stopped(signal,
                Format("stopped at step {}: the same command with --resume goes on",
                       WithThousands(size_t(iteration))));
}

void PrintEvaluation(const TrainOptions& o, Lpips* lpips) {
  const TestSummary summary = EvaluateTestImages(o.model, o.iterations, lpips);
  if (!o.quiet) std::printf("%s\n", ToString(summary).c_str());
}

void PrintTrained(const TrainingStatistics& s) {
  std::printf("%d iterations in %.1f s (%.2f ms per step at the end), %s Gaussians\n",
              s.iterations,
              s.seconds,
              s.ms_per_step,
              WithThousands(s.gaussians).c_str());
}

namespace {

void WriteBudget(const TrainOptions& o, const BudgetReport& report) {
  Json trials = Json::array();
  for (const BudgetTrial& trial : report.trials)
    trials.push_back({{"gaussians", trial.gaussians}, {"psnr", trial.psnr}});
  const Json json{{"tolerance_db", o.tolerance}, {"trials", trials}, {"gaussians", report.chosen}};
  WriteFileAtomically(o.model + "/budget.json", json.dump(2) + "\n");
}

void PrintBudget(const BudgetReport& report) {
  const BudgetTrial& all = report.trials.front();
  std::printf("budget: %s Gaussians unpruned, %.2f dB on the views held out\n",
              WithThousands(all.gaussians).c_str(),
              all.psnr);
  for (size_t i = 1; i < report.trials.size(); ++i)
    std::printf("  %s: %+.2f dB\n",
                WithThousands(report.trials[i].gaussians).c_str(),
                report.trials[i].psnr - all.psnr);
  std::printf("  chosen: %s\n", WithThousands(report.chosen).c_str());
}

// A run that can be interrupted after every step.
class TrainingRun {
 public:
  TrainingRun(const TrainOptions& o,
              Trainer& trainer,
              const RunHooks& hooks,
              RunCheckpoint& checkpoint)
      : o_(o), trainer_(trainer), hooks_(hooks), checkpoint_(checkpoint) {}

  void Start() {
    if (checkpoint_.resumes()) return Resume();
    if (o_.finds_budget) BeginSearch();
  }

  void ChooseBudget() {
    if (!search_) return;
    std::unique_ptr<ProgressBar> bar;
    size_t shown = size_t(-1);
    LossLine line;
    while (!search_->done()) {
      if (search_->trials() != shown) {
        shown = search_->trials();
        bar.reset();  // terminates its line
        bar = std::make_unique<ProgressBar>("budget, trial " + std::to_string(shown + 1),
                                            o_.iterations,
                                            o_.quiet,
                                            OffTerminal::kLines,
                                            trainer_.iteration());
      }
      const StepReport step = search_->Step();
      bar->Update(step.iteration, line(step));
      if (!search_->done()) AfterStep();
    }
    bar.reset();
    WriteBudget(o_, search_->report());
    if (!o_.quiet) PrintBudget(search_->report());
    search_.reset();
  }

  void Train() {
    ProgressBar bar("train", o_.iterations, o_.quiet, OffTerminal::kLines, trainer_.iteration());
    LossLine line;
    while (trainer_.iteration() < o_.iterations) {
      const int before = trainer_.iteration();
      const StepReport step = trainer_.Step();
      const int i = step.iteration;
      bar.Update(i, line(step));
      if (!step.notice.empty() && !o_.quiet) bar.Tell(step.notice);
      if (i == o_.iterations) break;
      if (o_.ReachesMilestone(o_.save_iterations, before, i)) hooks_.save();
      if (hooks_.evaluate && o_.ReachesMilestone(o_.test_iterations, before, i)) hooks_.evaluate();
      AfterStep();
    }
  }

  // Saves, measures and evaluates what was trained.
  void Finish(size_t skipped) {
    // Nothing is lost if the disk is too full for the results, or they are interrupted.
    TryToWriteCheckpoint();
    hooks_.save();
    StopIfAsked();
    const TrainingStatistics statistics = trainer_.statistics();
    if (writes()) WriteStatistics(o_.model, statistics, skipped);
    if (!hooks_.evaluate) return;
    hooks_.evaluate();
    StopIfAsked();
  }

  void StopIfAsked() { StopFor(int(Largest(uint32_t(signals_.received()), *hooks_.ranks))); }

 private:
  bool writes() const { return hooks_.ranks->rank() == 0; }

  void StopFor(int signal) {
    if (signal == 0) return;
    StopWithCheckpoint(signal, trainer_.iteration(), [&] { WriteCheckpoint(); });
  }

  void TryToWriteCheckpoint() {
    checkpoint_.Try([&] { WriteCheckpoint(); });
  }
  void WriteCheckpoint() { checkpoint_.Write(trainer_.iteration(), Description(), *hooks_.ranks); }

  void BeginSearch() {
    const bool video = hooks_.video_frames > 0;
    const size_t frames = video ? hooks_.video_frames : trainer_.frame_count();
    const BudgetSettings settings{o_.tolerance, FramesForBudget(frames, video)};
    search_.emplace(settings, trainer_);
  }

  void Resume() {
    checkpoint_.Read([&](StateArchive& a) {
      uint8_t searches = 0;
      a.Value("searches", searches);
      if (searches != 0) BeginSearch();
      SerializeRun(a);
    });
    PrintResumed(o_, trainer_.iteration());
  }

  void SerializeRun(StateArchive& a) { search_ ? search_->Serialize(a) : trainer_.Serialize(a); }

  StateDescription Description() {
    return [this](StateArchive& a) {
      uint8_t searches = search_.has_value();
      a.Value("searches", searches);
      SerializeRun(a);
    };
  }

  void AfterStep() {
    const Agreement agreed = AgreeAfterStep(signals_.received(), checkpoint_, *hooks_.ranks);
    StopFor(agreed.signal);
    if (agreed.checkpoint) TryToWriteCheckpoint();
  }

  const TrainOptions& o_;
  Trainer& trainer_;
  const RunHooks& hooks_;
  RunCheckpoint& checkpoint_;
  std::optional<BudgetSearch> search_;  // while there is a budget to find
  StopSignals signals_;
};

}  // namespace

void RunTraining(const TrainOptions& o,
                 Trainer& trainer,
                 const std::vector<SkippedFrame>& skipped,
                 const RunHooks& hooks,
                 RunCheckpoint& checkpoint) {
  const bool writes = hooks.ranks->rank() == 0;
  if (writes) RemoveTemporaries(o.model);
  if (writes) WriteSkipped(o.model, skipped);
  TrainingRun run(o, trainer, hooks, checkpoint);
  run.Start();
  run.ChooseBudget();
  run.Train();
  run.Finish(skipped.size());
  const TrainingStatistics statistics = trainer.statistics();
  if (!o.quiet) PrintTrained(statistics);
  // Density control may add some percent after the last round.
  if (!o.quiet && o.prune_to && double(statistics.gaussians) > 1.05 * double(*o.prune_to))
    std::printf("--prune-to %s: %s are left, since without more of them there would be holes\n",
                WithThousands(*o.prune_to).c_str(),
                WithThousands(statistics.gaussians).c_str());
  if (!o.quiet && o.drop_bands > 0)
    std::printf(
        "bands dropped: mean degree %.2f of %d, %.0f %% of the coefficients of bands 1 and up; "
        "%+.2f dB on training images at the time\n",
        statistics.bands.mean,
        o.sh_degree,
        100 * statistics.bands.rest_saved,
        statistics.drop_psnr);
  if (!hooks.evaluate) return;
  if (writes) PrintEvaluation(o, hooks.lpips);
  run.StopIfAsked();
}

}  // namespace cosplat
