#include "apps/cosplat/run/train_run.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/test_images.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/train/budget.h"

namespace cosplat {

void PrintSkipped(const std::vector<SkippedFrame>& skipped) {
  if (skipped.empty()) return;
  std::printf("%zu frames skipped:\n", skipped.size());
  constexpr size_t kListed = 5;
  for (size_t i = 0; i < std::min(kListed, skipped.size()); ++i)
    std::printf("  %s: %s\n", skipped[i].name.c_str(), skipped[i].reason.c_str());
  if (skipped.size() > kListed) std::printf("  ... (all are in skipped_frames.json)\n");
}

std::shared_ptr<Lpips> LoadLpips(const TrainOptions& o) {
  return o.lpips.empty() ? nullptr : std::make_shared<Lpips>(o.lpips);
}

namespace {

class LossLine {
 public:
  std::string operator()(const StepReport& step) {
    loss_ = step.iteration == 1 ? step.loss : 0.95 * loss_ + 0.05 * step.loss;
    char text[96];
    std::snprintf(
        text, sizeof text, "loss %.4f  %s Gaussians", loss_, WithThousands(step.gaussians).c_str());
    return text;
  }

 private:
  double loss_ = 0;
};

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

void ChooseBudget(const TrainOptions& o, Trainer& trainer, bool video) {
  const BudgetSettings settings{o.tolerance, FramesForBudget(trainer.frame_count(), video)};
  std::unique_ptr<ProgressBar> bar;
  size_t shown = size_t(-1);
  LossLine line;
  BudgetSearch search(settings, trainer);
  while (!search.done()) {
    if (search.trials() != shown) {
      shown = search.trials();
      bar.reset();  // terminates its line
      bar = std::make_unique<ProgressBar>(
          "budget, trial " + std::to_string(shown + 1), o.iterations, o.quiet, OffTerminal::kLines);
    }
    const StepReport step = search.Step();
    bar->Update(step.iteration, line(step));
  }
  const BudgetReport& report = search.report();
  bar.reset();
  WriteBudget(o, report);
  if (!o.quiet) PrintBudget(report);
}

}  // namespace

void RunTraining(const TrainOptions& o,
                 Trainer& trainer,
                 const std::vector<SkippedFrame>& skipped,
                 const RunHooks& hooks) {
  WriteSkipped(o.model, skipped);
  std::error_code ignored;
  std::filesystem::remove(o.model + "/budget.json", ignored);  // of an earlier run
  if (o.budget == "auto") ChooseBudget(o, trainer, hooks.video);
  {
    ProgressBar bar("train", o.iterations, o.quiet, OffTerminal::kLines);
    LossLine line;
    while (trainer.iteration() < o.iterations) {
      const StepReport step = trainer.Step();
      const int i = step.iteration;
      bar.Update(i, line(step));
      if (!step.notice.empty() && !o.quiet) bar.Tell(step.notice);
      if (o.ReachesMilestone(o.save_iterations, i)) hooks.save();
      if (i == o.iterations) WriteStatistics(o.model, trainer.statistics(), skipped.size());
      if (hooks.evaluate && o.ReachesMilestone(o.test_iterations, i)) hooks.evaluate();
    }
  }
  const TrainingStatistics statistics = trainer.statistics();
  if (!o.quiet)
    std::printf("%d iterations in %.1f s (%.2f ms per step at the end), %s Gaussians\n",
                o.iterations,
                statistics.seconds,
                statistics.ms_per_step,
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
  const TestSummary summary = EvaluateTestImages(o.model, o.iterations, hooks.lpips);
  if (!o.quiet) std::printf("%s\n", ToString(summary).c_str());
}

}  // namespace cosplat
