// cosplat play: shows an avatar or a scene in a window or, with --headless, renders it to files.
#include <cstdio>
#include <memory>
#include <utility>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/train_options.h"
#include "apps/cosplat/play_content.h"
#include "apps/cosplat/run/frame_sink.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/voice_drive.h"
#include "apps/viewer/viewer_state.h"
#include "apps/viewer/window.h"
#include "avatar/model/bust.h"
#include "avatar/play/avatar_renderer.h"
#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/media/image_io.h"
#include "splat/render/device_texture.h"

namespace cosplat {
namespace {

using viewer::Content;
using viewer::Session;
using viewer::Stage;

constexpr double kTurn = 6.283185307179586;

struct PlayOptions {
  std::string model, drive, flame, out, view = "splats", background, size;
  std::optional<Device> device = Device::kCpu;
  double fps = 0;
  int frames = 0;  // 0: the drive's length, or one without a drive
  float scale = 0;
  bool headless = false, transparent = false, still_bust = false, quiet = false;
  bool verbose = false;
};

void SetLook(const PlayOptions& o, Session& session) {
  const viewer::View view = viewer::ViewFromString(o.view, "--view");
  if (viewer::NeedsMesh(view) && !session.is_avatar())
    throw Error(o.model, "--view", o.view + " is only available for avatars; this is a scene");
  session.SetView(view);
  session.transparent = o.transparent;
  if (o.background == "black") session.background = {0, 0, 0};
  if (o.background == "white") session.background = {1, 1, 1};
}

// Renders the sequence's frames or, without a sequence, views of a full turn.
void PlayIntoFiles(const PlayOptions& o, Session& session, Stage& stage, PictureSize size) {
  if (IsLiveDrive(o.drive))
    throw Error("--headless", "plays recordings; '" + o.drive + "' needs the window");
  FrameSink sink(o.out,
                 session.has_sequence() ? session.timeline.frames_per_second() : kFramesPerSecond,
                 o.fps > 0 ? std::nullopt : VideoSoundOf(o.drive));
  if (o.transparent && sink.is_video())
    throw Error(o.out, "--transparent", "videos have no alpha: give a folder");
  const int frames = o.frames > 0 ? o.frames : std::max(1, session.timeline.frames());
  ProgressBar bar("play", frames, o.quiet);
  Image8 image;
  for (int i = 0; i < frames; ++i) {
    if (session.has_sequence()) session.timeline.Seek(i % session.timeline.frames());
    stage.Draw(session.ShotFor(size.width, size.height), image);
    sink.Write(o.transparent ? image : RgbOf(image));
    if (!session.has_sequence()) session.camera.Orbit(float(kTurn / frames), 0);
    bar.Update(i + 1, "frames");
  }
  sink.Finish();
  if (!o.quiet) std::printf("%d frames: %s\n", sink.count(), o.out.c_str());
}

// Scenes of more Gaussians than this are drawn by levels of detail, which take a second per two
// million to make.
constexpr size_t kLevelsFrom = 1000000;

// For the window, on the CPU: a device draws all Gaussians, and files are to be exact.
void FindLevels(const PlayOptions& o, Device device, Content& content) {
  if (content.levels && o.device == Device::kCuda)
    throw Error(o.model, "--device", "levels of detail are for the CPU: give the scene itself");
  if (device != Device::kCpu || o.headless || content.scene.size() <= kLevelsFrom) return;
  if (!o.quiet)
    std::fprintf(stderr,
                 "%s Gaussians: making levels of detail (export --levels keeps them as a file)\n",
                 WithThousands(content.scene.size()).c_str());
  content.levels = BuildLevels(std::move(content.scene));
}

void Play(const PlayOptions& o) {
  if (o.headless && o.out.empty())
    throw Error("--out", "is needed with --headless: a folder or a file that ends in .mp4");
  const Device device = UsableDevice(o.device);
  Content content = LoadContent(o.model, o.flame);
  if (o.still_bust && content.avatar) HoldBustStill(content.avatar->model);
  FindLevels(o, device, content);
  Session session(content);
  const auto driver = DriverOf(content, o.fps, o.verbose);
  if (content.avatar) session.open_drive = driver;
  if (!o.drive.empty()) driver(session, o.drive);
  SetLook(o, session);
  const PictureSize size =
      o.size.empty() ? PictureSize{content.start.camera.width, content.start.camera.height}
                     : ParsePictureSize(o.size);
  Stage stage(std::move(content), {AvatarRendererOn(device), SceneRendererOn(device)});
  if (o.headless) return PlayIntoFiles(o, session, stage, size);
  const std::string folder = o.out.empty() ? "." : o.out;
  const viewer::WindowSettings settings{
      o.scale, folder, DeviceTextureOn(device), viewer::ViewerStatePath()};
  viewer::ViewerWindow(session, stage, settings).Run();
}

void AddLook(CLI::App& command, PlayOptions& o) {
  command.add_option("--view", o.view, "splats, ellipsoids, triangles (by count) or wire");
  command
      .add_option("--background", o.background, "black or white; as it was evaluated if not given")
      ->check(CLI::IsMember({"black", "white"}));
  command.add_flag("--transparent", o.transparent, "no background: images with alpha");
}

}  // namespace

void AddPlay(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("play", "show an avatar or a scene in a window, or render it to files");
  const auto o = std::make_shared<PlayOptions>();
  command
      ->add_option(
          "model",
          o->model,
          "a run's folder, an avatar's .glb, GaussianAvatars' point cloud, or a scene's splats or "
          "levels of detail")
      ->required();
  auto* drive = command->add_option(
      "--drive",
      o->drive,
      "what moves an avatar: a tracked video, .npz, landmarks file or .csv of Live Link Face, "
      "webcam:, audio: (the microphone), audio:FILE, udp://HOST:PORT, vmc://HOST:PORT, "
      "vts://PHONE, ifacialmocap://PHONE, "
      "livelink://HOST or stdin:");
  command->add_option("--fps", o->fps, "frame rate of a recorded drive (default: its own)")
      ->needs(drive)
      ->check(CLI::Range(0.001, 10000.0));
  command->add_option("--flame", o->flame, "FLAME model file; the run's if not given");
  AddLook(*command, *o);
  AddDevice(*command, o->device, "where to render splats; auto: on an NVIDIA GPU if there is one");
  auto* headless =
      command->add_flag("--headless", o->headless, "render to files; needs no window or display");
  command->add_option("-o,--out",
                      o->out,
                      "headless: folder or .mp4; otherwise the folder of screenshots and videos");
  command
      ->add_option(
          "--frames", o->frames, "headless: number of frames of the drive, or of a full turn")
      ->needs(headless)
      ->check(CLI::Range(0, 1000000));
  command->add_flag("--still-bust",
                    o->still_bust,
                    "hold an avatar's shoulders still instead of following the head");
  command->add_option("--size", o->size, "headless: WIDTHxHEIGHT; as it was filmed if not given")
      ->needs(headless);
  command->add_option("--ui-scale", o->scale, "scale of text and panels; 0: the display's scale")
      ->check(CLI::Range(0.0, 8.0));
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command
      ->add_flag("--verbose",
                 o->verbose,
                 "live drives: print once a second what arrived, and by name what was not used")
      ->needs(drive);
  command->callback([o] { Play(*o); });
}

}  // namespace cosplat
