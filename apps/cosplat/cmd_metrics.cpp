// cosplat metrics: PSNR, SSIM and LPIPS of a run's test images.
#include <cstdio>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/test_images.h"

namespace cosplat {
namespace {

// `lpips_folder` may be empty.
void Measure(const std::string& model, const std::string& lpips_folder) {
  const Json json = ReadRun(model);
  const int iteration = SavedIteration(model, JsonField(model + "/run.json", json));
  std::unique_ptr<Lpips> lpips;
  if (!lpips_folder.empty()) lpips = std::make_unique<Lpips>(lpips_folder);
  std::unique_ptr<ProgressBar> bar;
  const TestSummary summary =
      EvaluateTestImages(model, iteration, lpips.get(), [&](int done, int total) {
        if (!bar) bar = std::make_unique<ProgressBar>("metrics", total);
        bar->Update(done, "views");
      });
  bar.reset();
  std::printf("%s\n", ToString(summary).c_str());
  for (const auto& [name, psnr] : summary.other_psnr)
    std::printf("%s: PSNR %.2f dB\n", name.c_str(), psnr);
  for (const std::string& line : summary.dropped) std::printf("dropped: %s\n", line.c_str());
}

}  // namespace

void AddMetrics(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "metrics", "PSNR, SSIM and LPIPS of the test views: results.json, per_view.json");
  const auto model = std::make_shared<std::string>(), lpips = std::make_shared<std::string>();
  command->add_option("-m,--model_path", *model, "a trained model's folder")->required();
  command->add_option("--lpips",
                      *lpips,
                      "LPIPS by the net in this folder: NET_backbone.onnx, NET_lin.npz and "
                      "NET_taps.txt (docs/lpips.md)");
  command->callback([=] { Measure(*model, *lpips); });
}

}  // namespace cosplat
