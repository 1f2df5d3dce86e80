#include <tbb/global_control.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "apps/cosplat/run/head_model.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/study/runs/study_runner.h"
#include "avatar/play/player.h"
#include "splat/base/error.h"
#include "splat/gaussians.h"
#include "splat/io/ply.h"
#include "splat/render/phase_times.h"
#include "splat/render/rasterizer.h"

namespace cosplat {
namespace {

// One thread, measured in CPU time, so that other load on the machine hardly matters.
constexpr int kThreads = 1;
constexpr int kMinPasses = 4;
constexpr double kMinSeconds = 1;  // over all passes, for views that render very fast

double SecondsOf(const std::function<void()>& f) {
  const double start = ProcessorSeconds();
  f();
  return ProcessorSeconds() - start;
}

// `pass` renders all `frames`.
double BestRate(size_t frames, const std::function<void()>& pass) {
  pass();  // allocates memory
  double best = std::numeric_limits<double>::infinity();
  const double start = ProcessorSeconds();
  for (int i = 0; i < kMinPasses || ProcessorSeconds() - start < kMinSeconds; ++i)
    best = std::min(best, SecondsOf(pass));
  return double(frames) / best;
}

double SceneRate(const std::string& folder, const JsonField& run) {
  Gaussians g = ReadPly(SplatPath(folder, SavedIteration(folder, run)));
  SortByDegree(g);
  const SceneData scene = LoadSplitScene(run["source"].String(), SplitFromJson(run));
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  const RenderSettings settings{BackgroundOf(run), g.degree};
  RenderedImage image;
  return BestRate(scene.test.size(), [&] {
    for (const SceneView& view : scene.test)
      rasterizer->Forward(ViewOf(g), g.basis, view.camera, settings, image, *tape);
  });
}

double AvatarRate(const std::string& folder, const JsonField& run) {
  auto [model, flame] = LoadPosable(folder + "/avatar.glb", &run, "");
  Player player(std::move(model), flame);
  const TrackedVideo video = LoadSplitVideo(run["source"].String(), SplitFromJson(run), flame);
  // A player does not render the same frame twice.
  if (video.test.size() < 2)
    throw Error(run["source"].String(), "test frames", "one is too few to measure the speed of");
  RenderedImage image;
  return BestRate(video.test.size(), [&] {
    for (const TrackedFrame& frame : video.test)
      player.RenderOver(frame.params, frame.camera, BackgroundOf(run), image);
  });
}

}  // namespace

double StudyFramesPerSecond(const std::string& folder) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, kThreads);
  const JsonField run = ReadRun(folder);
  return run["kind"].String() == "avatar" ? AvatarRate(folder, run) : SceneRate(folder, run);
}

}  // namespace cosplat
