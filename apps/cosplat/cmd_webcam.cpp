// cosplat webcam: the face that a camera sees, to a live avatar.
//
// Chromium with MediaPipe (apps/landmarks/camera.mjs) -> CameraFace -> lines or datagrams.
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/camera_face.h"
#include "apps/cosplat/run/mediapipe.h"
#include "apps/cosplat/run/packet_output.h"
#include "splat/base/error.h"
#include "splat/base/process.h"

namespace cosplat {
namespace {

struct WebcamOptions {
  std::string camera = "0", to;
  bool quiet = false;
};

// What is said of the camera: its name, and how it does, after ten seconds and ever more seldom.
class Report {
 public:
  explicit Report(bool quiet) : quiet_(quiet) {}

  void Saw(const CameraFrame& frame, bool sent) {
    const auto now = std::chrono::steady_clock::now();
    if (frames_ == 0 && !begun_ && !quiet_)
      std::fprintf(stderr,
                   "%s, %dx%d: look straight at it; Enter takes the neutral face again\n",
                   frame.camera.c_str(),
                   frame.width,
                   frame.height);
    if (!begun_) since_ = now;
    begun_ = true;
    ++frames_;
    sent_ += sent;
    milliseconds_ += frame.milliseconds;
    // Chromium on Linux has the camera's frames by this clock.
    age_ += std::chrono::duration<double>(now.time_since_epoch()).count() - frame.seconds;
    const double seconds = std::chrono::duration<double>(now - since_).count();
    if (seconds < next_) return;
    next_ *= 2;
    if (!quiet_) Say(seconds);
    since_ = now;
    frames_ = sent_ = 0;
    milliseconds_ = age_ = 0;
  }

 private:
  void Say(double seconds) const {
    std::fprintf(stderr,
                 "%.1f frames/s, %.0f%% with a face; finding it takes %.0f ms",
                 frames_ / seconds,
                 100.0 * sent_ / frames_,
                 milliseconds_ / frames_);
    const double age = age_ / frames_;
    if (age > 0 && age < kOldest)
      std::fprintf(stderr, ", and it is sent %.0f ms after the camera had it", 1000 * age);
    std::fprintf(stderr, "\n");
  }

  static constexpr double kOldest = 10;  // seconds; what is older is by another clock
  double next_ = 10;                     // seconds
  bool quiet_, begun_ = false;
  std::chrono::steady_clock::time_point since_;
  int frames_ = 0, sent_ = 0;
  double milliseconds_ = 0, age_ = 0;  // sums; age: seconds
};

// Whether the user has pressed Enter since the last call.
bool EnterPressed(bool& listens) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (!listens || poll(&input, 1, 0) <= 0) return false;
  char bytes[256];
  listens = read(STDIN_FILENO, bytes, sizeof bytes) > 0;
  return listens;
}

void CheckCamera(const std::string& camera) {
  const bool number = !camera.empty() && camera.size() < 4 &&
                      camera.find_first_not_of("0123456789") == std::string::npos;
  const std::string ending = std::filesystem::path(camera).extension().string();
  if (number) return;
  if (ending != ".y4m" && ending != ".mjpeg")
    throw Error("--camera", "found '" + camera + "', expected a number, or a film .y4m or .mjpeg");
  if (!std::filesystem::is_regular_file(camera)) throw Error(camera, "cannot be opened");
}

void Run(const WebcamOptions& o) {
  CheckCamera(o.camera);
  PacketOutput output(o.to);
  const Mediapipe mediapipe = FindMediapipe(o.quiet);
  CameraFace face;
  Report report(o.quiet);
  bool listens = isatty(STDIN_FILENO);
  std::string last;
  const auto use = [&](const std::string& line) {
    if (line.empty() || line[0] != '{') {
      if (!line.empty()) last = line;
      return;
    }
    if (EnterPressed(listens)) face.Calibrate();
    const CameraFrame frame = ParseCameraFrame(line);
    const auto packet = face.Next(frame);
    if (packet) output.Write(output.PacketOf(*packet, {}));
    report.Saw(frame, packet.has_value());
  };
  const int status = RunProcess(mediapipe.Command("camera.mjs", {"--camera", o.camera}), {}, use);
  throw Error("the camera's program", last.empty() ? ExitText(status) : last);
}

}  // namespace

void AddWebcam(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "webcam", "send the face that a camera sees to a live avatar; needs node and Chromium");
  const auto o = std::make_shared<WebcamOptions>();
  command->add_option(
      "--camera", o->camera, "which one, from 0; or a film, .y4m or .mjpeg, in place of one");
  command->add_option(
      "--to", o->to, "udp://HOST:PORT or vmc://HOST:PORT; lines on standard output if not given");
  command->add_flag("--quiet", o->quiet, "print nothing but errors and, without --to, the frames");
  command->callback([o] { Run(*o); });
}

}  // namespace cosplat
