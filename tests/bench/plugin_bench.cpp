// What libcosplat.so costs a host, through its C interface alone: the made head with 100
// expressions under 20,000 Gaussians of degree 3 (soak: 5,000), every parameter different in every
// frame. Latency also with a light and eight corrections.
//   cosplat_bench_plugin [PART...]
// Parts: open, latency, memory, many, soak (docs/plugin.md, "What it costs"); all if none is given.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/study/avatar_stability/painted_avatar.h"
#include "avatar/io/avatar_file.h"
#include "avatar/plugin/cosplat.h"
#include "flame/model.h"
#include "tests/avatar/with_corrections.h"
#include "tests/bench/bench_head.h"
#include "tests/support/soak.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using Clock = std::chrono::steady_clock;
using Pixels = std::vector<uint8_t>;
using test::MillisecondsSince;
using test::Quantile;

constexpr size_t kGaussians = 20000, kFewGaussians = 5000;
constexpr uint32_t kSide = 512, kSmallSide = 128;

// Ends the program when a call fails.
void Check(cosplat_status status, cosplat_avatar* avatar = nullptr) {
  if (status == COSPLAT_OK) return;
  std::fprintf(stderr, "%s: %s\n", cosplat_status_text(status), cosplat_last_error(avatar));
  std::exit(1);
}

struct Files {
  test::TemporaryFolder folder;
  std::string avatar = folder / "avatar.glb", flame = folder / "head.npz";
  FlameModel model;

  explicit Files(size_t gaussians = kGaussians, bool lit_and_corrected = false) {
    ProceduralHead head = BenchHead();
    WriteFlameModelNpz(flame, head.model);
    model = LoadFlameModel(flame);
    AvatarModel painted = PaintedAvatar(head, gaussians, 3);
    if (lit_and_corrected) {
      painted.light.emplace().fill(0.05f);
      painted = test::WithCorrections(std::move(painted), model, 8);
    }
    painted.flame_name = model.name;
    painted.flame_sha256 = model.sha256;
    WriteAvatarGlb(avatar, painted, nullptr);
  }
  double AvatarMegabytes() const { return double(std::filesystem::file_size(avatar)) / 1e6; }
  double FlameMegabytes() const { return double(std::filesystem::file_size(flame)) / 1e6; }
};

// An open avatar and the memory that it draws into.
class Show {
 public:
  explicit Show(const Files& files, bool with_depth = false)
      : story_(files.model),
        pixels_(size_t(4) * kSide * kSide),
        depth_(with_depth ? size_t(kSide) * kSide : 0) {
    cosplat_open_options options = {};
    options.struct_size = sizeof(options);
    options.flame_path = files.flame.c_str();
    Check(cosplat_open(files.avatar.c_str(), &options, &avatar_));
  }
  Show(Show&& other) noexcept
      : story_(other.story_),
        avatar_(std::exchange(other.avatar_, nullptr)),
        pixels_(std::move(other.pixels_)),
        depth_(std::move(other.depth_)) {}
  ~Show() { cosplat_close(avatar_); }

  const Pixels& Draw(int frame) {
    const cosplat_parameters parameters = story_.ParametersFor(frame);
    return Draw(parameters);
  }
  const Pixels& Draw(const cosplat_parameters& parameters) {
    cosplat_picture image = {};
    image.struct_size = sizeof(image);
    image.width = image.height = kSide;
    image.pixels = pixels_.data();
    image.depth = depth_.empty() ? nullptr : depth_.data();
    Check(cosplat_set_parameters(avatar_, &parameters), avatar_);
    Check(cosplat_advance(avatar_, parameters.time_ns), avatar_);
    Check(cosplat_render(avatar_, &image), avatar_);
    return pixels_;
  }
  // Milliseconds from parameters to pixels.
  float TimedDraw(int frame) {
    const cosplat_parameters parameters = story_.ParametersFor(frame);
    const auto start = Clock::now();
    Draw(parameters);
    return float(MillisecondsSince(start));
  }

 private:
  test::LiveStory story_;
  cosplat_avatar* avatar_ = nullptr;
  Pixels pixels_;
  std::vector<float> depth_;
};

void Open(const Files& files) {
  std::vector<float> opened, drawn;
  for (int i = 0; i < 15; ++i) {
    const auto start = Clock::now();
    Show show(files);
    opened.push_back(float(MillisecondsSince(start)));
    show.Draw(0);
    drawn.push_back(float(MillisecondsSince(start)));
  }
  const float first = drawn[0];
  std::printf("open: %.0f ms; open to first frame: %.0f ms, the process's first %.0f ms\n",
              Quantile(opened, 0.5),
              Quantile(drawn, 0.5),
              first);
}

void PrintLatency(const char* kind, const Files& files) {
  constexpr int kFrames = 10000, kFewer = 500;
  Show show(files);
  std::vector<float> times, again, deep;
  for (int f = 0; f < kFrames; ++f) times.push_back(show.TimedDraw(f));
  for (int i = 0; i < kFewer; ++i) again.push_back(show.TimedDraw(kFrames));
  Show deep_show(files, true);
  for (int f = 0; f < kFewer; ++f) deep.push_back(deep_show.TimedDraw(f));
  std::printf(
      "%s: parameters to pixels, %d frames of %ux%u: median %.1f ms, 99 %% %.1f, slowest %.1f\n",
      kind,
      kFrames,
      kSide,
      kSide,
      Quantile(times, 0.5),
      Quantile(times, 0.99),
      Quantile(times, 1));
  std::printf("%s: with depth: median %.1f ms; the same frame again: %.1f ms\n",
              kind,
              Quantile(deep, 0.5),
              Quantile(again, 0.5));
}

void Latency(const Files& files) {
  PrintLatency("plain", files);
  PrintLatency("light and corrections", Files(kGaussians, true));
}

void Memory(const Files& files) {
  constexpr int kAvatars = 8;
  Show first(files);
  first.Draw(0);
  const double before = test::ResidentMegabytes();
  std::vector<Show> shows;
  for (int i = 0; i < kAvatars; ++i) {
    shows.emplace_back(files);
    for (int f = 0; f < 5; ++f) shows.back().Draw(f);
  }
  const double pixels = 4e-6 * kSide * kSide;  // the host's
  const double each = (test::ResidentMegabytes() - before) / kAvatars - pixels;
  std::printf("a further avatar holds %.1f MB, %.2f times its file of %.1f MB (FLAME's has %.1f)\n",
              each,
              each / files.AvatarMegabytes(),
              files.AvatarMegabytes(),
              files.FlameMegabytes());
}

// Avatar a's frame f of a show.
int FrameOf(size_t a, int f) { return 100 * int(a) + f; }

// Milliseconds per image of `count` avatars, drawn in turn or each by a thread of its own;
// `unlike`: images at the end that are not those drawn alone.
struct Crowd {
  double milliseconds = 0;
  int unlike = 0;
};
Crowd DrawCrowd(const Files& files, size_t count, bool threads, const std::vector<Pixels>& alone) {
  constexpr int kFrames = 40;
  std::vector<Show> shows;
  for (size_t a = 0; a < count; ++a) shows.emplace_back(files).Draw(FrameOf(a, 0));
  const auto start = Clock::now();
  if (threads) {
    std::vector<std::thread> running;
    for (size_t a = 0; a < count; ++a)
      running.emplace_back([&, a] {
        for (int f = 1; f <= kFrames; ++f) shows[a].Draw(FrameOf(a, f));
      });
    for (std::thread& thread : running) thread.join();
  } else {
    for (int f = 1; f <= kFrames; ++f)
      for (size_t a = 0; a < count; ++a) shows[a].Draw(FrameOf(a, f));
  }
  Crowd crowd{MillisecondsSince(start) / double(kFrames * int(count)), 0};
  for (size_t a = 0; a < count; ++a)
    crowd.unlike += shows[a].Draw(FrameOf(a, kFrames + 1)) != alone[a];
  return crowd;
}

void Many(const Files& files) {
  constexpr size_t kMax = 16;
  constexpr int kLast = 41;
  std::vector<Pixels> alone;
  for (size_t a = 0; a < kMax; ++a) alone.push_back(Show(files).Draw(FrameOf(a, kLast)));
  std::printf("avatars  ms per image in turn  a thread each  images unlike those alone\n");
  for (const size_t count : {1, 2, 4, 8, 16}) {
    const Crowd turn = DrawCrowd(files, count, false, alone);
    const Crowd threads = DrawCrowd(files, count, true, alone);
    std::printf("%7zu %24.2f %14.2f %28d\n",
                count,
                turn.milliseconds,
                threads.milliseconds,
                turn.unlike + threads.unlike);
  }
}

// Images so small need fewer Gaussians.
void Soak(const Files&) {
  const Files files(kFewGaussians);
  const test::Soak::Settings settings{files.avatar, files.flame, 200000, 97, kSmallSide};
  const test::SoakReport r = test::Soak(files.model, settings).Run();
  std::printf(
      "%d frames of %ux%u: median %.2f ms, 99 %% %.2f, slowest %.1f; resident %.2f MB after a"
      " tenth, %.2f at the end\n",
      settings.frames,
      settings.side,
      settings.side,
      r.median_ms,
      r.slow_ms,
      r.slowest_ms,
      r.first_mb,
      r.last_mb);
  std::printf("  %llu bad, %llu late; calls with a wrong status: %d\n",
              static_cast<unsigned long long>(r.bad),
              static_cast<unsigned long long>(r.late),
              r.unexpected);
  std::printf(
      "  unlike a new avatar with all the inputs: %d of %d images; with the shown frame"
      " alone: %d of %d\n",
      r.unlike_replayed,
      r.checkpoints,
      r.unlike_plain,
      r.plain);
}

int Run(const std::vector<std::string>& parts) {
  const std::pair<const char*, void (*)(const Files&)> all[] = {
      {"open", Open}, {"latency", Latency}, {"memory", Memory}, {"many", Many}, {"soak", Soak}};
  for (const std::string& part : parts)
    if (std::none_of(
            std::begin(all), std::end(all), [&](const auto& p) { return part == p.first; }))
      return std::fprintf(stderr, "no part '%s'\n", part.c_str()), 2;
  const Files files;
  for (const auto& [name, measure] : all)
    if (parts.empty() || std::count(parts.begin(), parts.end(), name) > 0) measure(files);
  return 0;
}

}  // namespace
}  // namespace cosplat

int main(int argc, char** argv) { return cosplat::Run({argv + 1, argv + argc}); }
