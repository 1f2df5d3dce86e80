#include "apps/viewer/window.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <future>
#include <optional>

#include "apps/viewer/capture.h"
#include "apps/viewer/detail.h"
#include "apps/viewer/gl_window.h"
#include "apps/viewer/image_texture.h"
#include "apps/viewer/render_worker.h"
#include "apps/viewer/screen.h"
#include "apps/viewer/viewer_state.h"

namespace cosplat::viewer {
namespace {

// Maximum wait between turns in seconds, while something moves and while nothing does. Events and
// finished images end it early.
constexpr double kMovingTurn = 1.0 / 60, kRestingTurn = 0.25;
constexpr double kNoticeSeconds = 6;
constexpr int kSmallestSide = 16;

int64_t NowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

struct ViewerWindow::Impl {
  Impl(Session& session, Stage& stage, const WindowSettings& settings)
      : session(session),
        folder(settings.folder),
        state_file(settings.state_file),
        kept(KeptState()),
        gl("CoSplat - " + session.title(), settings.scale, kept.width, kept.height),
        texture(settings.make_device_texture),
        stage(stage),
        may_stay(bool(settings.make_device_texture)),
        worker(stage, &GlWindow::Wake) {
    state.scale = gl.scale();
    if (!kept_problem.empty()) Notice(kept_problem, true);
    if (state_file.empty()) return;
    session.panels_open = kept.panels_open;
    if (session.drive.empty()) session.drive = kept.drive;
  }

  // A damaged file is said, and written anew at the end.
  ViewerState KeptState() {
    try {
      return ReadViewerState(state_file);
    } catch (const std::exception& problem) {
      kept_problem = problem.what();
      return {};
    }
  }
  void KeepState() const;
  void ToggleDrive();

  void TakeImage();
  void ShowImage();
  const Image8& Pixels();
  // Neither smaller nor coarser because something is dragged.
  bool IsFinal() const {
    const RenderJob& job = picture.job;
    return job.divisor == 1 && !(stage.KeepsPace(job.shot.view) && job.shot.pace == Pace::kMoving);
  }
  bool HasImage() const { return picture.stayed || !picture.image.empty(); }
  void Ask(const ScreenResult& result);
  void Capture(const ScreenResult& result);
  void StartRecording();
  void StopRecording();
  void FinishSaving(bool wait);
  void OfferToRecording();
  void Notice(const std::string& text, bool problem);
  double TurnSeconds() const;

  Session& session;
  std::string folder, state_file, kept_problem;
  ViewerState kept;
  GlWindow gl;
  ImageTexture texture;
  const Stage& stage;  // for what does not change; the worker draws on it
  bool may_stay;       // whether images may stay on the device that renders them
  ScreenState state;
  ScreenResult last;
  Detail detail;
  FinishedImage picture;
  bool image_is_new = false, read_back = false;
  RenderJob asked;
  Image8 window_pixels;
  std::unique_ptr<VideoRecorder> recorder;
  int64_t recording_start_ns = 0;
  std::future<std::string> saving;  // path of the previous video
  bool screenshot_wanted = false;
  double notice_end = 0;  // glfwGetTime
  RenderWorker worker;    // last: it must stop before what it wakes is destroyed
};

void ViewerWindow::Impl::Notice(const std::string& text, bool problem) {
  state.notice = text;
  state.notice_is_problem = problem;
  notice_end = glfwGetTime() + kNoticeSeconds;
}

void ViewerWindow::Impl::KeepState() const {
  if (state_file.empty()) return;
  ViewerState now{0, 0, session.panels_open, session.drive};
  glfwGetWindowSize(gl.handle(), &now.width, &now.height);
  WriteViewerState(now, state_file);
}

void ViewerWindow::Impl::ToggleDrive() {
  try {
    if (session.live())
      session.SetLive(nullptr);
    else if (session.open_drive && !session.drive.empty())
      session.open_drive(session, session.drive);
  } catch (const std::exception& problem) {
    Notice(problem.what(), true);
  }
}

double ViewerWindow::Impl::TurnSeconds() const {
  const bool plays = session.driver == Driver::kSequence && session.timeline.playing();
  const bool live = session.driver == Driver::kLive && !session.live()->Ended();
  return plays || live || last.dragging || recorder || saving.valid() || screenshot_wanted
             ? kMovingTurn
             : kRestingTurn;
}

void ViewerWindow::Impl::TakeImage() {
  if (!worker.TakeImage(picture)) return;
  if (!picture.problem.empty()) return Notice(picture.problem, true);
  ShowImage();
  state.texture = intptr_t(texture.name());
  state.width = picture.job.shot.camera.width;
  state.height = picture.job.shot.camera.height;
  state.divisor = picture.job.divisor;
  state.drawing.Add(float(picture.milliseconds));
  detail.Drawn(picture.job.divisor, picture.milliseconds);
  image_is_new = true;
}

// If the device image cannot be copied into the texture directly, downloads it to the host; later
// images are then rendered to host memory.
void ViewerWindow::Impl::ShowImage() {
  if (picture.stayed) {
    try {
      return texture.Show(*picture.on_device);
    } catch (const std::exception& problem) {
      may_stay = false;
      Notice(std::string("Images pass through the host's memory: ") + problem.what(), false);
    }
  }
  texture.Upload(Pixels());
}

// The image's pixels, downloaded from the device if necessary.
const Image8& ViewerWindow::Impl::Pixels() {
  if (picture.stayed && picture.image.empty()) picture.on_device->Download(picture.image);
  return picture.image;
}

// Requests the image that the session shows now, unless it equals the last request.
void ViewerWindow::Impl::Ask(const ScreenResult& result) {
  // Levels of detail keep the time at full resolution.
  const bool keeps_pace = stage.KeepsPace(session.view());
  const int divisor = recorder || keeps_pace ? 1 : detail.Divisor(result.dragging);
  const int width = recorder ? recorder->width() : std::max(kSmallestSide, result.width / divisor);
  const int height =
      recorder ? recorder->height() : std::max(kSmallestSide, result.height / divisor);
  RenderJob job{session.ShotFor(width, height), divisor, session.input_ns(), may_stay && !recorder};
  if (recorder) job.shot.transparent = false;
  if (keeps_pace) job.shot.pace = result.dragging ? Pace::kMoving : Pace::kResting;
  if (job.shot == asked.shot) return;
  asked = job;
  worker.Start(std::move(job));
}

void ViewerWindow::Impl::StartRecording() {
  FinishSaving(true);
  recorder = std::make_unique<VideoRecorder>(CapturePath(folder, ".mp4"), last.width, last.height);
  recording_start_ns = NowNs();
}

// Finishing checks the file before it gets its name, which takes a while for a long video.
void ViewerWindow::Impl::StopRecording() {
  state.recorded_seconds = -1;
  saving = std::async(std::launch::async, [done = std::move(recorder)] {
    done->Finish();
    return done->path();
  });
}

void ViewerWindow::Impl::FinishSaving(bool wait) {
  if (!saving.valid()) return;
  if (!wait && saving.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  Notice("Saved " + saving.get(), false);
}

void ViewerWindow::Impl::OfferToRecording() {
  const double seconds = 1e-9 * double(NowNs() - recording_start_ns);
  state.recorded_seconds = seconds;
  const Shot& shot = picture.job.shot;
  const bool fits = HasImage() && shot.camera.width == recorder->width() &&
                    shot.camera.height == recorder->height() && !shot.transparent;
  if (fits) recorder->Offer(Pixels(), seconds);
}

void ViewerWindow::Impl::Capture(const ScreenResult& result) {
  try {
    FinishSaving(false);
    for (const Action action : result.actions) {
      if (action == Action::kScreenshot) screenshot_wanted = true;
      if (action == Action::kToggleRecording) recorder ? StopRecording() : StartRecording();
      if (action == Action::kQuit) glfwSetWindowShouldClose(gl.handle(), GLFW_TRUE);
    }
    if (recorder) OfferToRecording();
    if (screenshot_wanted && IsFinal() && HasImage()) {
      screenshot_wanted = false;
      const std::string path = CapturePath(folder, ".png");
      WriteImage(path, Pixels());
      Notice("Saved " + path, false);
    }
  } catch (const std::exception& problem) {
    recorder.reset();
    state.recorded_seconds = -1;
    screenshot_wanted = false;
    Notice(problem.what(), true);
  }
}

ViewerWindow::ViewerWindow(Session& session, Stage& stage, const WindowSettings& settings)
    : impl_(std::make_unique<Impl>(session, stage, settings)) {}

ViewerWindow::~ViewerWindow() = default;

bool ViewerWindow::Step() {
  Impl& impl = *impl_;
  impl.gl.BeginFrame(impl.TurnSeconds());
  impl.session.Advance(NowNs());
  impl.TakeImage();
  if (glfwGetTime() > impl.notice_end) impl.state.notice.clear();
  impl.state.pressed = impl.gl.TakePressed();
  const ScreenResult result = DrawScreen(impl.session, impl.state);
  for (const Action action : result.actions)
    if (action == Action::kToggleDrive) impl.ToggleDrive();
  impl.Ask(result);
  impl.Capture(result);
  impl.last = result;
  impl.gl.EndFrame();
  if (impl.read_back) impl.window_pixels = impl.gl.Read();
  impl.gl.Show();
  if (impl.image_is_new)
    impl.state.latency.Add(float(1e-6 * double(NowNs() - impl.picture.job.input_ns)));
  impl.image_is_new = false;
  return !glfwWindowShouldClose(impl.gl.handle());
}

void ViewerWindow::Run() {
  while (Step()) {
  }
  if (impl_->recorder) impl_->StopRecording();
  impl_->FinishSaving(true);
  try {
    impl_->KeepState();
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "The window's size and drive are not kept: %s\n", problem.what());
  }
}

GLFWwindow* ViewerWindow::handle() const { return impl_->gl.handle(); }

const std::string& ViewerWindow::notice() const { return impl_->state.notice; }

bool ViewerWindow::UpToDate() const {
  const Impl& impl = *impl_;
  return impl.HasImage() && !impl.worker.Busy() && impl.picture.job.shot == impl.asked.shot;
}

Image8 ViewerWindow::ReadPixels() {
  impl_->read_back = true;
  Step();
  impl_->read_back = false;
  return std::move(impl_->window_pixels);
}

}  // namespace cosplat::viewer
