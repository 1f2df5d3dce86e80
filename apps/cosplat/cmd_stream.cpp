// cosplat stream: an avatar, as it is driven, to a virtual camera or a server.
//
// drive -> Session -> Stage -> over a background -> LiveVideo.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/train_options.h"
#include "apps/cosplat/play_content.h"
#include "apps/cosplat/run/stop_signals.h"
#include "avatar/play/avatar_renderer.h"
#include "splat/base/error.h"
#include "splat/media/image_io.h"
#include "splat/media/live_video.h"

namespace cosplat {
namespace {

using viewer::Content;
using viewer::Session;
using viewer::Stage;

struct StreamOptions {
  std::string model, drive, to, flame, background, size = "1280x720";
  std::optional<Device> device = Device::kCpu;
  double fps = 30;
  int64_t frames = 0;  // 0: until it is interrupted
  bool quiet = false;
};

// What is behind the avatar: an image that fills the frame, cut at its longer side.
Image8 Backdrop(const std::string& path, int width, int height) {
  const Image8 image = RgbOf(ReadUpright(path));
  const double scale = std::max(double(width) / image.width, double(height) / image.height);
  const int w = std::max(width, int(std::lround(scale * image.width)));
  const int h = std::max(height, int(std::lround(scale * image.height)));
  return Cropped(ResizeByArea(image, w, h), {(w - width) / 2, (h - height) / 2, width, height});
}

// A straight alpha's image over another of its size, as RGB.
Image8 Over(const Image8& front, const Image8& back) {
  Image8 image(front.width, front.height, 3);
  for (size_t i = 0; i < size_t(front.width) * size_t(front.height); ++i) {
    const int alpha = front.data[4 * i + 3];
    for (size_t c = 0; c < 3; ++c)
      image.data[3 * i + c] = uint8_t(
          (alpha * front.data[4 * i + c] + (255 - alpha) * back.data[3 * i + c] + 127) / 255);
  }
  return image;
}

// "#rrggbb" sets the session's background; anything else is an image.
std::optional<Image8> SetBackground(const StreamOptions& o,
                                    Session& session,
                                    int width,
                                    int height) {
  if (o.background.empty()) return {};
  if (o.background[0] != '#') {
    session.transparent = true;
    return Backdrop(o.background, width, height);
  }
  if (o.background.size() != 7 ||
      o.background.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos)
    throw Error("--background", "found '" + o.background + "', expected #rrggbb or an image");
  const unsigned long rgb = std::stoul(o.background.substr(1), nullptr, 16);
  for (size_t c = 0; c < 3; ++c) session.background[c] = float((rgb >> (16 - 8 * c)) & 255) / 255;
  return {};
}

// Moves an avatar down until its shoulders end at the picture's lower edge, or a little below.
void StandOnEdge(Session& session, Stage& stage, int width, int height) {
  viewer::Shot shot = session.ShotFor(width, height);
  shot.transparent = true;
  Image8 image;
  stage.Draw(shot, image);
  int bottom = height;
  const auto is_empty = [&](int y) {
    for (int x = 0; x < width; ++x)
      if (image.at(x, y, 3) > 127) return false;
    return true;
  };
  while (bottom > 0 && is_empty(bottom - 1)) --bottom;
  constexpr float kBelow = 0.02f;  // of the height
  if (bottom > 0 && bottom < height)
    session.camera.Pan(0, float(height - bottom) / float(height) + kBelow);
}

void Run(const StreamOptions& o) {
  using Clock = std::chrono::steady_clock;
  const Device device = UsableDevice(o.device);
  const auto [width, height] = ParsePictureSize(o.size);
  Content content = LoadContent(o.model, o.flame);
  Session session(content);
  const std::optional<Image8> back = SetBackground(o, session, width, height);
  std::signal(SIGPIPE, SIG_IGN);  // who looks may go, which Write says
  if (!o.drive.empty()) DriverOf(content, 0, false)(session, o.drive);
  const auto output = OpenLiveVideo(o.to, width, height, o.fps);  // replaces a file
  Stage stage(std::move(content), {AvatarRendererOn(device), SceneRendererOn(device)});
  if (session.is_avatar()) StandOnEdge(session, stage, width, height);
  if (!o.quiet)
    std::printf("%s: %dx%d at %g frames/s; Ctrl-C ends it\n", o.to.c_str(), width, height, o.fps);
  std::fflush(stdout);
  const StopSignals signals;
  const Clock::time_point start = Clock::now();
  const auto since = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  int64_t number = 0, written = 0;
  Image8 image;
  while (signals.received() == 0 && (o.frames == 0 || number < o.frames)) {
    session.Advance(Clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
    if (session.live() && session.live()->Ended()) {
      if (o.drive != "stdin:" && o.drive != "audio:-") throw Error(o.drive, "has ended");
      break;
    }
    stage.Draw(session.ShotFor(width, height), image);
    output->Write(back ? Over(image, *back) : RgbOf(image), number);
    ++written;
    // What cannot be drawn in time is left out.
    number = std::max(number + 1, int64_t(std::floor(since() * o.fps)));
    std::this_thread::sleep_until(start +
                                  std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(double(number) / o.fps)));
  }
  if (!o.quiet)
    std::printf("%lld frames, %lld left out\n",
                static_cast<long long>(written),
                static_cast<long long>(number - written));
}

}  // namespace

void AddStream(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "stream", "play an avatar into a camera for meetings, or to a server, as it is driven");
  const auto o = std::make_shared<StreamOptions>();
  command->add_option("model", o->model, "as of play")->required();
  command->add_option("--drive", o->drive, "as of play, such as webcam:");
  command
      ->add_option("--to",
                   o->to,
                   "v4l2:DEVICE, a virtual camera of v4l2loopback; or an address: rtmp://HOST/KEY, "
                   "srt://HOST:PORT, udp://HOST:PORT, file:VIDEO.ts")
      ->required();
  command->add_option("--flame", o->flame, "FLAME model file; the run's if not given");
  command->add_option("--size", o->size, "WIDTHxHEIGHT");
  command->add_option("--fps", o->fps, "frames per second")->check(CLI::Range(1.0, 240.0));
  command->add_option(
      "--background", o->background, "#rrggbb, or an image; as it was evaluated if not given");
  AddDevice(*command, o->device, "where to render; auto: on an NVIDIA GPU if there is one");
  command->add_option("--frames", o->frames, "end after so many; 0: when it is interrupted")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { Run(*o); });
}

}  // namespace cosplat
