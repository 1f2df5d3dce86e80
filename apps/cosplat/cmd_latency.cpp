// cosplat latency: from a camera to the picture of an avatar, measured.
//
// a film in the camera's place -> camera.mjs -> CameraFace -> lines -> LiveSource -> FaceGuard ->
// Stage; each frame's times, and the jaw of the film beside that in the pictures.
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/train_options.h"
#include "apps/cosplat/play_content.h"
#include "apps/cosplat/run/camera_face.h"
#include "apps/cosplat/run/latency_film.h"
#include "apps/cosplat/run/mediapipe.h"
#include "avatar/live/guard.h"
#include "avatar/live/source.h"
#include "avatar/math/turn.h"
#include "avatar/play/avatar_renderer.h"
#include "flame/eyelids.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/process.h"

namespace cosplat {
namespace {

using viewer::Content;
using viewer::Session;
using viewer::Stage;

struct LatencyOptions {
  std::string model, flame, size = "512x512";
  std::optional<Device> device = Device::kCpu;
  int seconds = 20;
  bool quiet = false;
};

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// What became of a camera's frame; seconds by the clock of Now.
struct Seen {
  double captured = 0, finding = 0, arrived = 0;
  int film_frame = 0;
};
struct Drawn {
  Seen seen;
  double begun = 0, done = 0;
  LatencyFilm::Truth shown;  // the avatar's own
};

// Of a face that is drawn; lids of a head that has none are 0.
LatencyFilm::Truth ShownBy(FlameParams face, const Content::Avatar& avatar) {
  const auto root = [](const FlameParams& params) { return math::QuatOfAxisAngle(params.pose[0]); };
  EyelidsFromExpression(avatar.flame, face);
  return {face.pose[2][0],
          face.eyelids,
          math::AxisAngleOf(math::Multiply(root(face), math::Conjugate(root(avatar.rest))))};
}

// The camera's program and what it says, in a thread of its own.
class FilmedCamera {
 public:
  FilmedCamera(const Mediapipe& mediapipe, const LatencyFilm& film)
      : child_(mediapipe.Command(
                   "camera.mjs",
                   {"--camera", film.path, "--bar", std::to_string(LatencyFilm::kCells)}),
               {},
               ChildProcess::Errors::kWithOutput),
        frames_(film.frames.size()) {
    if (pipe2(pipe_, O_CLOEXEC) != 0) throw Error("a pipe", "cannot be had");
    thread_ = std::thread([this] { Read(); });
  }
  ~FilmedCamera() {
    ended_ = true;
    thread_.join();
    close(pipe_[0]);
    close(pipe_[1]);
  }

  int lines() const { return pipe_[0]; }
  Seen Of(uint64_t sequence) {
    const std::lock_guard lock(mutex_);
    return seen_.at(sequence % seen_.size());
  }
  // Throws what the program said last if it has ended.
  void Check() {
    const std::lock_guard lock(mutex_);
    if (!problem_.empty()) throw Error("the camera's program", problem_);
  }

 private:
  void Read() {
    std::string rest;
    char bytes[65536];
    constexpr int kPatience = 100;  // milliseconds
    while (!ended_) {
      pollfd output{child_.output(), POLLIN, 0};
      if (poll(&output, 1, kPatience) == 0) continue;
      const ssize_t count = read(child_.output(), bytes, sizeof bytes);
      if (count <= 0) break;
      rest.append(bytes, size_t(count));
      for (size_t end; (end = rest.find('\n')) != rest.npos; rest.erase(0, end + 1))
        Use(rest.substr(0, end));
    }
    const std::lock_guard lock(mutex_);
    if (!ended_ && problem_.empty()) problem_ = last_.empty() ? "has ended" : last_;
  }

  void Use(const std::string& line) {
    if (line.empty() || line[0] != '{') {
      last_ = line;
      return;
    }
    const double arrived = Now();
    try {
      const CameraFrame frame = ParseCameraFrame(line);
      const std::optional<JsonFrame> packet = face_.Next(frame);
      if (!packet || frame.bar < 0) return;
      {
        const std::lock_guard lock(mutex_);
        seen_[packet->sequence % seen_.size()] = {
            frame.seconds, frame.milliseconds / 1000, arrived, int(size_t(frame.bar) % frames_)};
      }
      const std::string text = WriteJsonFrame(*packet) + "\n";
      if (write(pipe_[1], text.data(), text.size()) != ssize_t(text.size())) ended_ = true;
    } catch (const std::exception& problem) {
      const std::lock_guard lock(mutex_);
      problem_ = problem.what();
      ended_ = true;
    }
  }

  ChildProcess child_;
  size_t frames_;
  CameraFace face_;
  int pipe_[2];
  std::mutex mutex_;
  std::array<Seen, 256> seen_;  // the newest, by sequence number
  std::string last_, problem_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

constexpr double kLate = 0.05;  // seconds between pictures of a camera of 30 frames per second

double Quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// How a number in the pictures follows the film's.
struct Follows {
  double lag = 0, r = -1;  // seconds at which the two correlate best, and how well
  double scatter = 0;      // standard deviation of the difference there
};

template <class Of>
Follows FollowsFilm(const std::vector<Drawn>& drawn, const LatencyFilm& film, const Of& of) {
  constexpr double kStep = 0.005, kLongest = 0.5;
  Follows best;
  for (double lag = 0; lag < kLongest; lag += kStep) {
    double a = 0, b = 0, aa = 0, bb = 0, ab = 0, n = 0;
    for (const Drawn& picture : drawn) {
      // What the film showed `lag` before, by this picture's own frame and its time.
      const double at = picture.seen.film_frame + (picture.done - lag - picture.seen.captured) *
                                                      LatencyFilm::kFramesPerSecond;
      if (at < 0 || at >= double(film.frames.size() - 1)) continue;
      const auto whole = size_t(at);
      const double part = at - double(whole);
      const double x =
          (1 - part) * double(of(film.frames[whole])) + part * double(of(film.frames[whole + 1]));
      const double y = double(of(picture.shown));
      a += x, b += y, aa += x * x, bb += y * y, ab += x * y, ++n;
    }
    const double vx = n * aa - a * a, vy = n * bb - b * b, cov = n * ab - a * b;
    const double r = cov / std::sqrt(vx * vy + 1e-30);
    if (r > best.r) best = {lag, r, std::sqrt(std::max(0.0, vx + vy - 2 * cov)) / n};
  }
  return best;
}

void PrintTimes(const std::vector<Drawn>& drawn, double seconds) {
  const auto row = [&](const char* name, auto&& of) {
    std::vector<double> values;
    for (const Drawn& d : drawn) values.push_back(1000 * of(d));
    std::printf("%-32s %6.0f %6.0f\n", name, Quantile(values, 0.5), Quantile(values, 0.9));
  };
  std::printf("%zu pictures of new frames in %.0f s\n%-32s %6s %6s\n",
              drawn.size(),
              seconds,
              "milliseconds",
              "median",
              "90 %");
  row("camera to the browser, and here",
      [](const Drawn& d) { return d.seen.arrived - d.seen.captured - d.seen.finding; });
  row("finding the face", [](const Drawn& d) { return d.seen.finding; });
  row("waiting for the picture before", [](const Drawn& d) { return d.begun - d.seen.arrived; });
  row("drawing", [](const Drawn& d) { return d.done - d.begun; });
  row("camera to picture", [](const Drawn& d) { return d.done - d.seen.captured; });
  size_t late = 0;
  double longest = 0;
  for (size_t i = 1; i < drawn.size(); ++i) {
    const double apart = drawn[i].done - drawn[i - 1].done;
    late += apart > kLate;
    longest = std::max(longest, apart);
  }
  std::printf("%zu came more than %.0f ms after the one before, at most %.0f ms\n",
              late,
              1000 * kLate,
              1000 * longest);
}

void PrintFollows(const std::vector<Drawn>& drawn, const LatencyFilm& film) {
  using Truth = LatencyFilm::Truth;
  constexpr double kDegrees = 57.29577951308232;
  std::printf("\n%-32s %6s %6s\n", "behind the film, smoothed", "ms", "r");
  const auto row = [&](const char* name, auto&& of, bool is_angle) {
    const Follows follows = FollowsFilm(drawn, film, of);
    std::printf("%-32s %6.0f %6.3f", name, 1000 * follows.lag, follows.r);
    if (is_angle) std::printf("   scatters by %.1f degrees", kDegrees * follows.scatter);
    std::printf("\n");
  };
  row(
      "jaw", [](const Truth& t) { return t.jaw; }, false);
  row(
      "left lid", [](const Truth& t) { return t.lids[0]; }, false);
  row(
      "right lid", [](const Truth& t) { return t.lids[1]; }, false);
  row(
      "head, nod", [](const Truth& t) { return t.turn[0]; }, true);
  row(
      "head, shake", [](const Truth& t) { return t.turn[1]; }, true);
  row(
      "head, tilt", [](const Truth& t) { return t.turn[2]; }, true);
}

std::vector<Drawn> Watch(const LatencyOptions& o, FilmedCamera& camera, Content content) {
  const auto [width, height] = ParsePictureSize(o.size);
  const Device device = UsableDevice(o.device);
  const Content::Avatar avatar = *content.avatar;  // the stage has its own
  LiveSourceOptions options;
  options.rest = avatar.rest;
  options.flame = &avatar.flame;
  if (avatar.model.blendshapes) options.blendshapes = &*avatar.model.blendshapes;
  const auto source = OpenLineSource(camera.lines(), "the film", options);
  FlameParams rest = avatar.rest;
  rest.expression.assign(size_t(avatar.flame.expression_count), 0);
  FaceGuard guard(rest, avatar.model.trained_range);
  Session session(content);
  Stage stage(std::move(content), {AvatarRendererOn(device), SceneRendererOn(device)});
  viewer::Shot shot = session.ShotFor(width, height);
  std::vector<Drawn> drawn;
  drawn.reserve(size_t(o.seconds) * 2 * LatencyFilm::kFramesPerSecond);
  LiveFrame frame;
  Image8 image;
  const double opened = Now();
  double begun = 0;  // at the first frame
  while (begun == 0 || Now() < begun + o.seconds) {
    camera.Check();
    const double now = Now();
    constexpr double kPatience = 60;  // seconds for Chromium and its packages
    if (begun == 0 && now > opened + kPatience)
      throw Error("the camera's program", "has seen no face for 60 s");
    if (!source->Poll(int64_t(1e9 * now), frame)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      continue;
    }
    if (begun == 0) begun = now;
    if (guard.Offer(frame.params, frame.time_ns) != Verdict::kAccepted) continue;
    shot.face = guard.At(int64_t(1e9 * now));
    stage.Draw(shot, image);
    drawn.push_back({camera.Of(frame.sequence), now, Now(), ShownBy(shot.face, avatar)});
  }
  return drawn;
}

void Run(const LatencyOptions& o) {
  Content content = LoadContent(o.model, o.flame);
  if (!content.avatar) throw Error(o.model, "is a scene; expected an avatar");
  const Mediapipe mediapipe = FindMediapipe(o.quiet);
  const std::string folder =
      TemporaryPath((std::filesystem::temp_directory_path() / "cosplat_latency").string());
  struct Removed {
    const std::string& path;
    ~Removed() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  } removed{folder};
  constexpr int kFilmFrames = 150;
  if (!o.quiet) std::fprintf(stderr, "Making a film of %d frames\n", kFilmFrames);
  const LatencyFilm film = MakeLatencyFilm(folder, kFilmFrames);
  FilmedCamera camera(mediapipe, film);
  const std::vector<Drawn> drawn = Watch(o, camera, std::move(content));
  if (drawn.size() < 20)
    throw Error(o.model, std::to_string(drawn.size()) + " pictures", "are too few to say anything");
  PrintTimes(drawn, o.seconds);
  PrintFollows(drawn, film);
}

}  // namespace

void AddLatency(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "latency", "measure the time from a camera to an avatar's picture; needs node and Chromium");
  const auto o = std::make_shared<LatencyOptions>();
  command->add_option("model", o->model, "an avatar, as of play")->required();
  command->add_option("--flame", o->flame, "FLAME model file; the run's if not given");
  command->add_option("--size", o->size, "WIDTHxHEIGHT of the picture");
  command->add_option("--seconds", o->seconds, "how long to watch")->check(CLI::Range(5, 86400));
  AddDevice(*command, o->device, "where to render; auto: on an NVIDIA GPU if there is one");
  command->add_flag("--quiet", o->quiet, "print nothing but errors and the result");
  command->callback([o] { Run(*o); });
}

}  // namespace cosplat
