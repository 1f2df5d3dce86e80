// cosplat train-scene: a static scene from photographs.
#include <cstdio>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/progress_bar.h"
#include "apps/cosplat/run_folder.h"
#include "apps/cosplat/test_images.h"
#include "apps/cosplat/train_options.h"
#include "splat/base/error.h"
#include "splat/dataset.h"
#include "splat/initialize.h"
#include "splat/io/cameras_json.h"
#include "splat/io/ply.h"
#include "splat/trainer.h"

namespace cosplat {
namespace {

constexpr size_t kRandomPoints = 100000;  // 3DGS, for scenes without points

struct SceneOptionsAll : TrainOptions {
  size_t random_points = kRandomPoints;
};

std::array<float, 3> FixedBackground(const TrainSettings& s) {
  const float c = s.background == Background::kBlack ? 0.0f : 1.0f;
  return {c, c, c};
}

void Evaluate(const std::string& folder,
              const SceneData& scene,
              const Trainer& trainer,
              const std::array<float, 3>& background) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  const Gaussians& g = trainer.state().gaussians;
  TestImageWriter writer(folder, trainer.state().iteration, background);
  RenderedImage image;
  for (const SceneView& view : scene.test) {
    const RenderSettings render{background, trainer.active_degree()};
    rasterizer->Forward(ViewOf(g), g.basis, view.camera, render, image, *tape);
    writer.Write(image, LoadViewImage(view));
  }
  writer.Finish();
}

void SaveInputs(const SceneOptionsAll& o, const SceneData& scene, const std::string& config) {
  const Json run{{"kind", "scene"},
                 {"source", o.source},
                 {"resolution", o.resolution},
                 {"eval", o.eval},
                 {"fold", o.fold},
                 {"iterations", o.iterations},
                 {"degree", o.sh_degree},
                 {"basis", o.basis},
                 {"seed", o.seed},
                 {"white_background", o.white_background},
                 {"version", COSPLAT_VERSION}};
  WriteRunConfiguration(o.model, o, config, run);
  std::vector<NamedCamera> cameras;
  for (const auto* views : {&scene.test, &scene.train})
    for (const SceneView& view : *views) cameras.push_back({view.name, view.camera});
  WriteCamerasJson(o.model + "/cameras.json", cameras);
  WritePointsPly(o.model + "/input.ply", scene.points, scene.point_colors);
}

void Train(SceneOptionsAll o, const std::string& config) {
  SceneData scene = LoadScene(o.source, {o.resolution, o.eval, o.fold});
  if (o.background == "auto" && scene.white_background_hint) o.white_background = true;
  const TrainSettings settings = o.ToSettings(scene.extent);
  if (!o.quiet && !scene.skipped.empty())
    std::printf("%zu frames skipped, the first: %s: %s\n",
                scene.skipped.size(),
                scene.skipped[0].name.c_str(),
                scene.skipped[0].reason.c_str());
  if (scene.points.empty()) {
    Rng rng{o.seed};
    std::vector<Camera> cameras;
    for (const SceneView& view : scene.train) cameras.push_back(view.camera);
    RandomPoints(cameras, o.random_points, rng, scene.points, scene.point_colors);
  }
  SaveInputs(o, scene, config);
  SceneSubject subject(LoadTrainFrames(scene.train), scene.extent);
  Trainer trainer(settings,
                  subject,
                  InitializeFromPoints(
                      scene.points, scene.point_colors, o.sh_degree, BasisFromString(o.basis)));
  if (!o.quiet)
    std::printf("%s: %zu training and %zu test views of %dx%d, %s points\n",
                scene.layout.c_str(),
                scene.train.size(),
                scene.test.size(),
                scene.train[0].camera.width,
                scene.train[0].camera.height,
                WithThousands(scene.points.size() / 3).c_str());
  {
    ProgressBar bar("train", o.iterations);
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
      if (o.ReachesMilestone(o.save_iterations, i))
        SaveSplats(o.model, i, trainer.state().gaussians);
      if (!scene.test.empty() && o.ReachesMilestone(o.test_iterations, i))
        Evaluate(o.model, scene, trainer, FixedBackground(settings));
    }
  }
  const TrainingStatistics statistics = trainer.statistics();
  WriteStatistics(o.model, statistics, scene.skipped.size());
  if (!o.quiet)
    std::printf("%d iterations in %.1f s (%.2f ms per step at the end), %s Gaussians\n",
                o.iterations,
                statistics.seconds,
                statistics.ms_per_step,
                WithThousands(statistics.gaussians).c_str());
  if (!scene.test.empty()) {
    const TestSummary summary = EvaluateTestImages(o.model, o.iterations);
    if (!o.quiet) std::printf("%s\n", ToString(summary).c_str());
  }
}

}  // namespace

void AddTrainScene(CLI::App& app) {
  CLI::App* command = app.add_subcommand("train-scene", "train a static scene from photographs");
  const auto options = std::make_shared<SceneOptionsAll>();
  options->Declare(*command);
  command
      ->add_option("--preset",
                   options->preset,
                   "default: schedules in proportion to --iterations; 3dgs: its absolute steps")
      ->check(CLI::IsMember({"default", "3dgs"}));
  command->add_option("--random_points",
                      options->random_points,
                      "Gaussians to start with where the data has no points");
  command->callback([options, command, &app] { Train(*options, ConfigOf(app, *command)); });
}

}  // namespace cosplat
