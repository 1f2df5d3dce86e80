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

// A run that can be interrupted after every step.
class TrainingRun {
 public:
  TrainingRun(const TrainOptions& o,
              Trainer& trainer,
              const RunHooks& hooks,
              RunCheckpoint& checkpoint)
      : o_(o), trainer_(trainer), hooks_(hooks), checkpoint_(checkpoint) {}

  void Start() {
    if (!checkpoint_.resumes()) return;
    checkpoint_.Read([&](StateArchive& a) { trainer_.Serialize(a); });
    PrintResumed(o_, trainer_.iteration());
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
  void WriteCheckpoint() {
    const StateDescription state = [this](StateArchive& a) { trainer_.Serialize(a); };
    checkpoint_.Write(trainer_.iteration(), state, *hooks_.ranks);
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
  run.Train();
  run.Finish(skipped.size());
  const TrainingStatistics statistics = trainer.statistics();
  if (!o.quiet) PrintTrained(statistics);
  const std::string& rule = trainer.settings().prune.rule;
  if (!o.quiet && statistics.pruned > 0)
    std::printf("pruned: %s Gaussians by %s\n",
                WithThousands(statistics.pruned).c_str(),
                rule == "none" ? "--triangle-cap" : rule.c_str());
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
