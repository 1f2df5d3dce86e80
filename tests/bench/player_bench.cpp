// Where the milliseconds of a playback frame go, and how many frames a second that makes, in order,
// with the next frame posed meanwhile, and as preview: the made head under Gaussians in its
// colours, 512 x 512, every FLAME parameter different in every frame. Plain; with a light; with a
// light and eight corrections.
//   cosplat_bench_player [COUNT...]      Gaussians; 5000 20000 60000 if not given
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "apps/study/avatar_stability/painted_avatar.h"
#include "assets/head/motion.h"
#include "avatar/play/playback.h"
#include "splat/train/loss/loss.h"
#include "tests/avatar/with_corrections.h"
#include "tests/bench/bench_head.h"
#include "tests/support/restless_params.h"

namespace cosplat {
namespace {

constexpr int kSize = 512, kFrames = 24, kRepeats = 5;
constexpr float kDistance = 0.80f;  // metres: the head covers two fifths of the image

using Clock = std::chrono::steady_clock;
double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Milliseconds per stage: of each frame the least of several runs, then the mean over the frames.
struct Stages {
  double pose = 0, surface = 0, bind = 0, project = 0, sort = 0, blend = 0;
  double Total() const { return pose + surface + bind + project + sort + blend; }
  template <class F>
  void ForEach(const Stages& other, const F& f) {
    f(pose, other.pose);
    f(surface, other.surface);
    f(bind, other.bind);
    f(project, other.project);
    f(sort, other.sort);
    f(blend, other.blend);
  }
};

class StagedPlayer {
 public:
  StagedPlayer(const AvatarModel& avatar, const FlameModel& flame, const Camera& camera)
      : avatar_(avatar),
        camera_(camera),
        poser_(flame, {}, {}, {}),
        surface_(avatar.mesh),
        rasterizer_(MakeCpuRasterizer()),
        tape_(rasterizer_->MakeTape()) {}

  Stages Play(const FlameParams& params) {
    Stages s;
    auto start = Clock::now();
    const auto parameters = poser_.ParametersFor(params);
    poser_.Forward(parameters, vertices_);
    s.pose = MillisecondsSince(start);
    start = Clock::now();
    surface_.Pose(vertices_);
    s.surface = MillisecondsSince(start);
    start = Clock::now();
    Bind(avatar_, surface_, posed_, CorrectionWeights(avatar_.correction_map, parameters));
    s.bind = MillisecondsSince(start);
    rasterizer_->times = {};
    rasterizer_->Forward(PosedView(avatar_.gaussians, posed_, avatar_.color_frame),
                         avatar_.gaussians.basis,
                         camera_,
                         {{1, 1, 1}, avatar_.gaussians.degree},
                         image_,
                         *tape_);
    const auto& seconds = rasterizer_->times.seconds;
    s.project = 1e3 * seconds[size_t(Phase::kProject)];
    s.sort = 1e3 * seconds[size_t(Phase::kSort)];
    s.blend = 1e3 * seconds[size_t(Phase::kBlend)];
    return s;
  }

  // Share of the pixels that the head hides at least half.
  double Coverage() const {
    size_t covered = 0;
    for (const float t : image_.transmittance) covered += t < 0.5f;
    return double(covered) / double(image_.transmittance.size());
  }

 private:
  const AvatarModel& avatar_;
  Camera camera_;
  AvatarPoser poser_;
  Surface surface_;
  std::vector<float> vertices_;
  PosedGaussians posed_;
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  RenderedImage image_;
};

Stages MeasureStages(StagedPlayer& player, const std::vector<PlaybackFrame>& frames) {
  Stages mean;
  std::vector<Stages> best(frames.size());
  for (int repeat = 0; repeat < kRepeats; ++repeat)
    for (size_t f = 0; f < frames.size(); ++f)
      best[f].ForEach(player.Play(frames[f].params),
                      [&](double& min, double ms) { min = repeat == 0 ? ms : std::min(min, ms); });
  for (const Stages& s : best)
    mean.ForEach(s, [&](double& sum, double ms) { sum += ms / double(frames.size()); });
  return mean;
}

// Frames per second: the fastest of several runs through the frames.
template <class F>
double FramesPerSecond(size_t frames, const F& play) {
  double min = 1e30;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const auto start = Clock::now();
    play();
    min = std::min(min, MillisecondsSince(start));
  }
  return 1e3 * double(frames) / min;
}

void PlayInOrder(Player& player, const std::vector<PlaybackFrame>& frames) {
  RenderedImage image;
  for (const PlaybackFrame& f : frames) player.RenderOver(f.params, f.camera, f.background, image);
}

void PlayPipelined(Player& player, const std::vector<PlaybackFrame>& frames) {
  Playback playback(player);
  for (const PlaybackFrame& f : frames) playback.Next(f);
  playback.Finish();
}

double PreviewPsnr(Player& full, Player& preview, const PlaybackFrame& f) {
  RenderedImage a, b;
  full.RenderOver(f.params, f.camera, f.background, a);
  preview.RenderOver(f.params, f.camera, f.background, b);
  return Psnr(b.color, a.color);
}

struct BenchAvatar {
  const char* kind;
  AvatarModel model;
  size_t size() const { return model.size(); }
};

void PrintStages(const BenchAvatar& avatar,
                 const FlameModel& flame,
                 const std::vector<PlaybackFrame>& frames,
                 size_t threads) {
  StagedPlayer player(avatar.model, flame, frames[0].camera);
  const Stages s = MeasureStages(player, frames);
  std::printf("%-9s %9zu %7zu %6.2f %7.2f %7.2f %7.2f %7.2f %7.2f %7.2f %6.0f%%\n",
              avatar.kind,
              avatar.size(),
              threads,
              s.pose,
              s.surface,
              s.bind,
              s.project,
              s.sort,
              s.blend,
              s.Total(),
              100 * player.Coverage());
}

void PrintRates(const BenchAvatar& avatar,
                const FlameModel& flame,
                const std::vector<PlaybackFrame>& frames,
                size_t threads) {
  Player player(avatar.model, flame), preview(avatar.model, flame, {true});
  const double in_order = FramesPerSecond(frames.size(), [&] { PlayInOrder(player, frames); });
  Image8 image;
  const double bytes = FramesPerSecond(frames.size(), [&] {
    for (const PlaybackFrame& f : frames) player.Render(f.params, f.camera, image);
  });
  const double pipelined = FramesPerSecond(frames.size(), [&] { PlayPipelined(player, frames); });
  const double half = FramesPerSecond(frames.size(), [&] { PlayPipelined(preview, frames); });
  std::printf("%-9s %9zu %7zu %9.0f %10.0f %9.0f %9.0f %8.1f dB\n",
              avatar.kind,
              avatar.size(),
              threads,
              in_order,
              bytes,
              pipelined,
              half,
              PreviewPsnr(player, preview, frames[0]));
}

void Run(const std::vector<size_t>& counts) {
  const ProceduralHead head = BenchHead();
  std::vector<PlaybackFrame> frames;
  for (int f = 0; f < kFrames; ++f)
    frames.push_back({test::RestlessParams(head.model, f),
                      procedural::OrbitCamera(0, 0, kDistance, kSize),
                      {1, 1, 1}});
  std::vector<BenchAvatar> avatars;
  for (const size_t count : counts) {
    avatars.push_back({"plain", PaintedAvatar(head, count)});
    avatars.push_back({"lit", avatars.back().model});
    avatars.back().model.light.emplace().fill(0.05f);
    avatars.push_back({"corrected", test::WithCorrections(avatars.back().model, head.model, 8)});
  }
  const auto for_each = [&](const auto& print) {
    for (const BenchAvatar& avatar : avatars)
      for (const size_t threads : {1, 2}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        print(avatar, head.model, frames, threads);
      }
  };
  std::printf("milliseconds per frame\n");
  std::printf(
      "kind      gaussians threads   pose surface    bind project    sort   blend   total "
      "covered\n");
  for_each(PrintStages);
  std::printf("frames per second\n");
  std::printf("kind      gaussians threads  in order RGBA bytes pipelined   preview  its PSNR\n");
  for_each(PrintRates);
}

}  // namespace
}  // namespace cosplat

int main(int argc, char** argv) {
  std::vector<size_t> counts;
  for (int i = 1; i < argc; ++i) counts.push_back(std::strtoul(argv[i], nullptr, 10));
  cosplat::Run(counts.empty() ? std::vector<size_t>{5000, 20000, 60000} : counts);
}
