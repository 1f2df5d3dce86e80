#include "apps/cosplat/train_run.h"

#include <algorithm>
#include <cstdio>

#include "apps/cosplat/progress_bar.h"
#include "apps/cosplat/run_folder.h"
#include "apps/cosplat/test_images.h"

namespace cosplat {

void PrintSkipped(const std::vector<SkippedFrame>& skipped) {
  if (skipped.empty()) return;
  std::printf("%zu frames skipped:\n", skipped.size());
  constexpr size_t kListed = 5;
  for (size_t i = 0; i < std::min(kListed, skipped.size()); ++i)
    std::printf("  %s: %s\n", skipped[i].name.c_str(), skipped[i].reason.c_str());
  if (skipped.size() > kListed) std::printf("  ... (all are in skipped_frames.json)\n");
}

void RunTraining(const TrainOptions& o,
                 Trainer& trainer,
                 const std::vector<SkippedFrame>& skipped,
                 const RunHooks& hooks) {
  WriteSkipped(o.model, skipped);
  {
    ProgressBar bar("train", o.iterations, o.quiet);
    double loss = 0;
    for (int i = 1; i <= o.iterations; ++i) {
      const StepReport step = trainer.Step();
      loss = i == 1 ? step.loss : 0.95 * loss + 0.05 * step.loss;
      char detail[96];
      std::snprintf(detail,
                    sizeof detail,
                    "loss %.4f  %s Gaussians",
                    loss,
                    WithThousands(step.gaussians).c_str());
      bar.Update(i, detail);
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
        "bands dropped: mean degree %.2f of %d, %.0f %% of the coefficients from band 1 on; "
        "%+.2f dB on training pictures at the time\n",
        statistics.bands.mean,
        o.sh_degree,
        100 * statistics.bands.rest_saved,
        statistics.drop_psnr);
  if (!hooks.evaluate) return;
  const TestSummary summary = EvaluateTestImages(o.model, o.iterations);
  if (!o.quiet) std::printf("%s\n", ToString(summary).c_str());
}

}  // namespace cosplat
