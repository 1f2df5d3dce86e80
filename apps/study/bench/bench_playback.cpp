#include <algorithm>
#include <cmath>

#include "apps/study/bench/bench_series.h"
#include "apps/study/bench/measure.h"
#include "assets/head/motion.h"
#include "assets/head/procedural_head.h"
#include "avatar/model/avatar_mesh.h"
#include "avatar/play/playback.h"
#include "avatar/play/player.h"
#include "avatar/surface/sample.h"
#include "splat/base/rng.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr size_t kUsualSplats = 20000;
constexpr int kSide = 512;          // px
constexpr float kDistance = 0.84f;  // metres: the head covers 40 to 50 % of the image
constexpr int kFrames = 24;

// Splats spread over the head as at the start of training, with the opacity of trained ones.
AvatarModel MakeAvatar(const FlameModel& flame, size_t count) {
  AvatarModel avatar;
  avatar.mesh = MakeCanonicalMesh(flame, {}, {}, {});
  Rng rng{1};
  for (const SurfacePoint& p : SampleSurface(avatar.mesh, count, rng)) {
    avatar.embedding.triangle.push_back(p.triangle);
    avatar.embedding.barycentric.push_back(p.barycentric);
  }
  Gaussians& g = avatar.gaussians;
  g.degree = 2;
  g.Resize(count);
  constexpr double kHeadArea = 0.25;  // square metres, approximate; shared equally by the splats
  const float spacing = float(std::sqrt(kHeadArea / double(count)));
  for (size_t i = 0; i < count; ++i) {
    g.at(kRotation, i)[0] = 1;
    *g.at(kOpacityLogit, i) = 2;
    for (int k = 0; k < 3; ++k) {
      g.at(kScaleLog, i)[k] = std::log(spacing) + 0.2f * rng.Normal();
      g.at(kColorDc, i)[k] = rng.Normal();
    }
    for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = 0.1f * rng.Normal();
  }
  return avatar;
}

// Every parameter differs in every frame: the script's motion plus a wave on each.
std::vector<PlaybackFrame> MakeMotion() {
  std::vector<PlaybackFrame> motion;
  for (const procedural::ScriptFrame& scripted : procedural::MakeScript({kFrames, 0, kSide, 0})) {
    const float time = 0.7f * float(motion.size());
    const auto wave = [time](size_t k) { return std::sin(time + float(k)); };
    FlameParams p = scripted.params;
    for (size_t k = 0; k < p.expression.size(); ++k) p.expression[k] += 0.1f * wave(k);
    for (size_t joint = 0; joint < p.pose.size(); ++joint)
      for (size_t k = 0; k < 3; ++k) p.pose[joint][k] += 0.01f * wave(3 * joint + k);
    for (size_t k = 0; k < 3; ++k) p.translation[k] += 0.002f * wave(k);
    const Camera camera = procedural::OrbitCamera(0.1f * wave(0), 0, kDistance, kSide);
    motion.push_back({std::move(p), camera, {1, 1, 1}});
  }
  return motion;
}

// A playback mode.
struct Mode {
  const char* name;
  bool pipelined, half_resolution;
};
// avatar_fps is measured with the first one.
constexpr Mode kModes[] = {{"next frame posed meanwhile", true, false},
                           {"frame by frame", false, false},
                           {"half-resolution preview", true, true}};

// Calls `seen` with the image of every frame.
template <class F>
void PlayOnce(const std::vector<PlaybackFrame>& motion, bool pipelined, Player& player, F seen) {
  if (!pipelined) {
    RenderedImage image;
    for (const PlaybackFrame& frame : motion) {
      player.RenderOver(frame.params, frame.camera, frame.background, image);
      seen(image);
    }
    return;
  }
  Playback playback(player);
  for (const PlaybackFrame& frame : motion)
    if (const RenderedImage* image = playback.Next(frame)) seen(*image);
  seen(*playback.Finish());
}

// One player per mode, measured alternately, so that other load on the machine affects all of them.
// Returns the fastest pass of each.
std::vector<double> FramesPerSecond(const BenchRun& run, std::vector<Player>& players) {
  const std::vector<PlaybackFrame> motion = MakeMotion();
  std::vector<double> best(players.size(), 0);
  for (int round = 0; round < (run.quick ? 1 : 6); ++round)
    for (size_t i = 0; i < players.size(); ++i) {
      const double seconds = FastestSeconds(1, 1, [&] {
        PlayOnce(motion, kModes[i].pipelined, players[i], [](const RenderedImage&) {});
      });
      best[i] = std::max(best[i], kFrames / seconds);
    }
  return best;
}

// Share of pixels that the head mostly covers, over all frames.
double CoveredShare(Player& player) {
  size_t covered = 0, pixels = 0;
  PlayOnce(MakeMotion(), false, player, [&](const RenderedImage& image) {
    pixels += image.transmittance.size();
    for (const float t : image.transmittance) covered += t < 0.5f;
  });
  return double(covered) / double(pixels);
}

}  // namespace

BenchSeries MeasurePlayback(const BenchRun& run, OrderedJson& head) {
  const FlameModel flame = MakeProceduralHead();
  std::vector<size_t> counts{2000, 5000, 10000, kUsualSplats, 50000, 100000};
  if (run.quick) counts = {5000, kUsualSplats};
  BenchSeries s;
  s.key = "playback";
  s.explanation =
      "Frames per second of an avatar (degree 2) on a 512x512 image, every parameter of the head "
      "changing in every frame, all threads.";
  s.statistic = "fastest pass over 24 frames";
  s.chart = {Chart::Kind::kLines,
             "Playback of an avatar",
             {"splats", "", true},
             {"playback", "frames/s", true},
             {},
             {}};
  for (const Mode& mode : kModes) s.chart.series.push_back({mode.name, {}});
  for (const size_t splats : counts) {
    run.progress("playback, " + WithThousands(splats) + " splats");
    std::vector<Player> players;
    for (const Mode& mode : kModes)
      players.emplace_back(MakeAvatar(flame, splats), flame, PlayerSettings{mode.half_resolution});
    const std::vector<double> best = FramesPerSecond(run, players);
    for (size_t i = 0; i < best.size(); ++i)
      s.chart.series[i].marks.push_back({double(splats), best[i], ""});
    if (splats != kUsualSplats) continue;
    head["avatar_fps"] = best[0];
    s.more = {{"covered", CoveredShare(players[0])}};
  }
  return s;
}

}  // namespace cosplat
