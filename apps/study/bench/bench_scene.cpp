#include "apps/study/bench/bench_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "apps/cosplat/options/train_options.h"
#include "apps/cosplat/run/run_data.h"
#include "assets/head/motion.h"
#include "assets/head/video.h"
#include "splat/base/error.h"
#include "splat/eval/metrics.h"
#include "splat/media/image_io.h"
#include "splat/train/start/initialize.h"
#include "splat/train/subject/scene_subject.h"

namespace cosplat {
namespace {

constexpr int kDegree = 3;

TrainOptions OptionsFor(const BenchScene& scene, const TrainingChoice& choice) {
  TrainOptions o;
  o.iterations = choice.iterations;
  o.seed = choice.seed;
  o.sh_degree = kDegree;
  o.background = scene.background;
  o.max_gaussians = scene.max_gaussians;
  return o;
}

std::vector<TrainFrame> Reduced(const std::vector<TrainFrame>& frames, int divisor) {
  if (divisor == 1) return frames;
  std::vector<TrainFrame> reduced;
  for (const TrainFrame& frame : frames) {
    const int width = std::max(1, frame.camera.width / divisor);
    const int height = std::max(1, frame.camera.height / divisor);
    reduced.push_back(
        {frame.camera.Resized(width, height), ResizeByArea(frame.target, width, height)});
  }
  return reduced;
}

std::unique_ptr<Subject> MakeSubject(const BenchScene& scene, const TrainingChoice& choice) {
  std::vector<TrainFrame> frames = Reduced(scene.train, choice.divisor);
  return std::make_unique<SceneSubject>(std::move(frames), scene.extent);
}

// Mean over the held-out views, on 8-bit images over the background.
double HeldOutPsnr(const BenchScene& scene,
                   const Gaussians& gaussians,
                   const RenderSettings& settings) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage rendered;
  double sum = 0;
  for (const TrainFrame& frame : scene.test) {
    rasterizer->Forward(
        ViewOf(gaussians), gaussians.basis, frame.camera, settings, rendered, *tape);
    sum += CompareImages(ToBytes(rendered.ToImage()),
                         OverBackground(frame.target, settings.background))
               .psnr;
  }
  return sum / double(scene.test.size());
}

std::vector<Camera> CamerasAround(int side, int views) {
  std::vector<Camera> cameras;
  for (int i = 0; i < views; ++i) {
    const float turn = 6.2831853f * float(i) / float(views);
    constexpr float kDistance = 0.95f;  // metres, as in the procedural head's video
    cameras.push_back(
        procedural::OrbitCamera(turn, 0.45f * std::sin(3.7f * float(i)), kDistance, side));
  }
  return cameras;
}

}  // namespace

BenchScene MakeHeadScene(int side, int views) {
  const ProceduralHead head = MakeProceduralHeadParts();
  BenchScene scene;
  scene.name = "made head";
  scene.points = head.model.template_vertices;
  scene.point_colors.assign(scene.points.size(), 128);
  scene.max_gaussians = 20000;
  FlameParams rest;
  rest.expression.assign(size_t(head.model.expression_count), 0.0f);
  std::vector<SceneView> seen;
  const std::vector<Camera> cameras = CamerasAround(side, views);
  for (size_t i = 0; i < cameras.size(); ++i) {
    TrainFrame frame{cameras[i],
                     RenderProceduralHead(head, head.model.template_vertices, rest, cameras[i])};
    (i % 5 == 4 ? scene.test : scene.train).push_back(std::move(frame));
    seen.push_back({});
    seen.back().camera = cameras[i];
  }
  scene.extent = SceneExtent(seen);
  return scene;
}

BenchScene LoadBenchScene(const std::string& path, int resolution) {
  SceneData data = LoadSplitScene(path, {{resolution, true, false}});
  BenchScene scene;
  scene.name = std::filesystem::path(path).lexically_normal().filename().string();
  scene.train = LoadTrainFrames(data.train, data.skipped);
  scene.test = LoadTrainFrames(data.test, data.skipped);
  CheckSkipped(path, scene.train.size() + scene.test.size(), data.skipped);
  if (scene.train.empty() || scene.test.empty())
    throw Error(path, "views", "bench needs some to train on and some to hold out");
  scene.extent = data.extent;
  if (data.renderings) scene.background = Background::kWhite;
  scene.max_gaussians = 35000;
  if (data.points.empty()) {
    Rng rng{0};
    std::vector<Camera> cameras;
    for (const TrainFrame& frame : scene.train) cameras.push_back(frame.camera);
    RandomPoints(cameras, scene.max_gaussians / 2, rng, data.points, data.point_colors);
  }
  LimitPoints(scene.max_gaussians, data.points, data.point_colors);
  scene.points = std::move(data.points);
  scene.point_colors = std::move(data.point_colors);
  return scene;
}

TrainedScene TrainBenchScene(const BenchScene& scene, const TrainingChoice& choice) {
  const TrainOptions options = OptionsFor(scene, choice);
  TrainSettings settings = options.ToSettings(scene.extent);
  settings.exp_degree = choice.shortcuts.exp_degree;
  settings.adam_on = choice.shortcuts.adam_on;
  const std::unique_ptr<Subject> subject = MakeSubject(scene, choice);
  Trainer trainer(settings,
                  *subject,
                  InitializeFromPoints(scene.points, scene.point_colors, kDegree, Basis::kDcsh));
  for (int i = 0; i < choice.iterations; ++i) trainer.Step();
  TrainedScene trained;
  trained.gaussians = trainer.state().gaussians;
  trained.seconds = trainer.statistics().seconds;
  trained.memory = trainer.Memory();
  trained.psnr = HeldOutPsnr(
      scene, trained.gaussians, {options.EvaluationBackground(), trainer.active_degree()});
  return trained;
}

double StepMs(const BenchScene& scene,
              const TrainingChoice& choice,
              const Gaussians& trained,
              int steps) {
  return TimeSteps(Reduced(scene.train, choice.divisor), trained, 2, steps, choice.shortcuts)
      .mean_ms;
}

}  // namespace cosplat
