#include "tests/gpu/scene_times.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "apps/cosplat/run/scene_start.h"
#include "splat/base/error.h"
#include "splat/device/cuda/stream.h"
#include "splat/eval/metrics.h"
#include "splat/media/image_io.h"
#include "splat/train/step/step_engine.h"
#include "tests/gpu/packed_scene.h"

namespace cosplat::test {
namespace {

constexpr int kLookEvery = 100;  // steps between looks at the free memory
constexpr int kTellEvery = 1000;

struct Options {
  std::string file, out;
  TrainOptions choices;
};

struct Result {
  TrainingStatistics training;
  size_t peak_bytes = 0;  // of the device, beyond what was taken before the run
  size_t views = 0;
  double psnr = 0, ssim = 0;
};

Options Parse(const std::vector<std::string>& arguments) {
  Options o;
  o.choices.device = Device::kCuda;
  const auto number = [](const std::string& name, const std::string& text) {
    char* end = nullptr;
    const long value = std::strtol(text.c_str(), &end, 10);
    if (end == text.c_str() || *end != 0 || value < 1 || value > 100000000)
      throw Error("", name, "'" + text + "' is not a number of at least 1");
    return int(value);
  };
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& name = arguments[i];
    const bool has_value = i + 1 < arguments.size();
    if (name == "--out" && has_value)
      o.out = arguments[++i];
    else if (name == "--iterations" && has_value)
      o.choices.iterations = number(name, arguments[++i]);
    else if (name == "--prune-to" && has_value)
      o.choices.prune_to = size_t(number(name, arguments[++i]));
    else if (name.rfind("--", 0) != 0 && o.file.empty())
      o.file = name;
    else
      throw Error("", name, "is not known, or lacks its value");
  }
  if (o.file.empty()) throw Error("", "scene", "FILE is needed");
  if (o.out.empty()) throw Error("", "--out", "is needed");
  return o;
}

void Evaluate(const TrainOptions& o,
              const std::vector<TrainFrame>& test,
              const Trainer& trainer,
              Result& result) {
  const auto rasterizer = MakeRasterizer(o.ResolveDevice());
  const auto tape = rasterizer->MakeTape();
  const Gaussians g = trainer.CaughtUp();
  const RenderSettings render{o.EvaluationBackground(), trainer.active_degree()};
  RenderedImage image;
  for (const TrainFrame& frame : test) {
    rasterizer->Forward(ViewOf(g), g.basis, frame.camera, render, image, *tape);
    const ImageMetrics metrics =
        CompareImages(ToBytes(image.ToImage()), OverBackground(frame.target, render.background));
    result.psnr += metrics.psnr / double(test.size());
    result.ssim += metrics.ssim / double(test.size());
  }
  result.views = test.size();
}

Result Train(TrainOptions o, TrainingScene scene) {
  const size_t free_before = cuda::FreeMemory();
  SceneStart start = StartScene({}, o, scene);
  SceneSubject subject(std::move(scene.train), scene.extent);
  Trainer trainer(start.settings,
                  subject,
                  std::move(start.first),
                  StepEngineOn(o.ResolveDevice(), o.deterministic));
  size_t min_free = free_before;
  while (trainer.iteration() < o.iterations) {
    const StepReport step = trainer.Step();
    if (!step.notice.empty()) std::printf("%s\n", step.notice.c_str());
    if (step.iteration % kLookEvery == 0 || step.iteration == o.iterations)
      min_free = std::min(min_free, cuda::FreeMemory());
    if (step.iteration % kTellEvery != 0) continue;
    std::printf("%d: loss %.4f, %zu Gaussians\n", step.iteration, step.loss, step.gaussians);
    std::fflush(stdout);
  }
  Result result;
  trainer.state();  // all that was submitted is done
  result.training = trainer.statistics();
  result.peak_bytes = free_before - min_free;
  Evaluate(o, scene.test, trainer, result);
  return result;
}

void Write(const Options& o, const std::string& card, const Result& r) {
  const std::string part = o.out + ".part";
  std::FILE* file = std::fopen(part.c_str(), "w");
  if (!file) throw Error(o.out, "", "cannot be written");
  std::fprintf(file,
               "{\"device\": \"%s\", \"iterations\": %d, \"prune_to\": %zu,\n"
               " \"seconds\": %.3f, \"ms_per_step\": %.4f, \"gaussians\": %zu,\n"
               " \"peak_device_bytes\": %zu, \"views\": %zu, \"psnr\": %.4f, \"ssim\": %.6f}\n",
               card.c_str(),
               o.choices.iterations,
               o.choices.prune_to.value_or(0),
               r.training.seconds,
               r.training.ms_per_step,
               r.training.gaussians,
               r.peak_bytes,
               r.views,
               r.psnr,
               r.ssim);
  const bool written = !std::ferror(file);
  if (std::fclose(file) != 0 || !written || std::rename(part.c_str(), o.out.c_str()) != 0)
    throw Error(o.out, "", "cannot be written");
}

}  // namespace

void RunSceneBench(const std::vector<std::string>& arguments) {
  const Options o = Parse(arguments);
  const std::string card = NameOf(o.choices.ResolveDevice());
  TrainingScene scene = ReadPackedScene(o.file);
  std::printf("%s: %zu training and %zu test views, on %s\n",
              o.file.c_str(),
              scene.train.size(),
              scene.test.size(),
              card.c_str());
  const Result r = Train(o.choices, std::move(scene));
  Write(o, card, r);
  std::printf(
      "%d iterations in %.1f s (%.2f ms per step at the end), %zu Gaussians, %.2f GB at the most;"
      " PSNR %.2f dB, SSIM %.4f over %zu views\n",
      o.choices.iterations,
      r.training.seconds,
      r.training.ms_per_step,
      r.training.gaussians,
      1e-9 * double(r.peak_bytes),
      r.psnr,
      r.ssim,
      r.views);
}

}  // namespace cosplat::test
