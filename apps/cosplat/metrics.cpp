// cosplat metrics: PSNR and SSIM of a run's test pictures.
#include <cstdio>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run_folder.h"
#include "apps/cosplat/test_images.h"

namespace cosplat {

void AddMetrics(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("metrics", "PSNR and SSIM of the test views: results.json, per_view.json");
  const auto model = std::make_shared<std::string>();
  command->add_option("-m,--model_path", *model, "a trained model's folder")->required();
  command->callback([model] {
    const Json json = ReadRun(*model);
    const JsonField run(*model + "/run.json", json);
    const TestSummary summary = EvaluateTestImages(*model, SavedIteration(*model, run));
    std::printf("%s\n", ToString(summary).c_str());
  });
}

}  // namespace cosplat
