// cosplat train-scene: trains a static scene from images.
#include <cstdio>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/train_options.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/scene_start.h"
#include "apps/cosplat/run/test_images.h"
#include "apps/cosplat/run/train_run.h"
#include "splat/base/error.h"
#include "splat/io/cameras_json.h"
#include "splat/io/ply.h"
#include "splat/train/scene_subject.h"
#include "splat/train/trainer.h"

namespace cosplat {
namespace {

struct SceneCommand : TrainOptions {
  size_t random_points = 0;
};

void Evaluate(const SceneCommand& o,
              Device device,
              const std::vector<TrainFrame>& test,
              const Trainer& trainer) {
  const auto rasterizer = MakeRasterizer(device);
  const auto tape = rasterizer->MakeTape();
  const Gaussians g = trainer.CaughtUp();
  const RenderSettings render{o.EvaluationBackground(), trainer.active_degree()};
  TestImageWriter writer(o.model, "test", trainer.iteration(), render.background);
  RenderedImage image;
  for (const TrainFrame& frame : test) {
    rasterizer->Forward(ViewOf(g), g.basis, frame.camera, render, image, *tape);
    writer.Write(image, frame.target);
  }
  writer.Finish();
}

void SaveInputs(const SceneCommand& o,
                const DataSplit& split,
                const SceneData& scene,
                const std::string& config) {
  const Json run{{"kind", "scene"},
                 {"source", o.source},
                 {"split", ToJson(split)},
                 {"iterations", o.iterations},
                 {"degree", o.sh_degree},
                 {"basis", o.basis},
                 {"seed", o.seed},
                 {"device", NameOf(o.ResolveDevice())},
                 {"background", o.EvaluationBackground()},
                 {"version", COSPLAT_VERSION}};
  WriteRunConfiguration(o.model, o, config, run);
  std::vector<NamedCamera> cameras;
  for (const auto* views : {&scene.test, &scene.train})
    for (const SceneView& view : *views) cameras.push_back({view.name, view.camera});
  WriteCamerasJson(o.model + "/cameras.json", cameras);
  WritePointsPly(o.model + "/input.ply", scene.points, scene.point_colors);
}

void Train(SceneCommand o, const std::string& config) {
  if (o.prune == "dcsharp-triangle")
    throw Error("--prune dcsharp-triangle", "needs triangles: available in train-avatar only");
  const Device device = o.ResolveDevice();
  const std::shared_ptr<Lpips> lpips = LoadLpips(o);
  const DataSplit split{o.resolution, o.eval, o.fold, -1};
  SceneData scene = LoadSplitScene(o.source, split);
  TrainingScene loaded = LoadTrainingScene(scene);
  SceneStart start = StartScene(o.random_points, o, loaded);
  start.settings.crop_loss.distance = lpips;
  const std::vector<TrainFrame> test = std::move(loaded.test);
  SceneSubject subject(std::move(loaded.train), loaded.extent);
  Trainer trainer(
      start.settings, subject, std::move(start.first), StepEngineOn(device, o.deterministic));
  scene.points = std::move(loaded.points);  // the initial points of the run
  scene.point_colors = std::move(loaded.point_colors);
  SaveInputs(o, split, scene, config);
  if (!o.quiet) PrintSkipped(scene.skipped);
  if (!o.quiet)
    std::printf("%s: %zu training and %zu test views of %dx%d, %s points, on %s\n",
                scene.layout.c_str(),
                scene.train.size(),
                scene.test.size(),
                subject.frame(0).camera.width,
                subject.frame(0).camera.height,
                WithThousands(scene.points.size() / 3).c_str(),
                NameOf(device).c_str());
  RunHooks hooks;
  hooks.lpips = lpips.get();
  hooks.save = [&, saves = CanSaveSplats(o)] {
    if (saves) SaveSplats(o.model, trainer.iteration(), trainer.CaughtUp());
  };
  if (!test.empty()) hooks.evaluate = [&] { Evaluate(o, device, test, trainer); };
  RunTraining(o, trainer, scene.skipped, hooks);
}

}  // namespace

void AddTrainScene(CLI::App& app) {
  CLI::App* command = app.add_subcommand("train-scene", "train a static scene from photographs");
  const auto options = std::make_shared<SceneCommand>();
  options->Declare(*command);
  command
      ->add_option(
          "--preset",
          options->preset,
          "default: in proportion to --iterations, better and faster; 3dgs: as its code does")
      ->check(CLI::IsMember({"default", "3dgs"}));
  command
      ->add_option(
          "--random-points,--random_points",
          options->random_points,
          "number of random initial points for data without points; 0: the preset's choice "
          "(default: points found in the images; 3dgs: 100,000)")
      ->check(CLI::Range(size_t(0), kMaxGaussians));
  command->callback([options, command, &app] { Train(*options, ConfigOf(app, *command)); });
}

}  // namespace cosplat
