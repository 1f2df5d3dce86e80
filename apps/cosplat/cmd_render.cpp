// cosplat render: renders a trained model's test views, an orbit, or an avatar driven by a
// sequence or by chance.
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/train_options.h"
#include "apps/cosplat/run/camera_path.h"
#include "apps/cosplat/run/frame_sink.h"
#include "apps/cosplat/run/head_model.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/test_images.h"
#include "apps/cosplat/run/voice_drive.h"
#include "avatar/live/soft_range.h"
#include "avatar/model/bust.h"
#include "avatar/play/avatar_renderer.h"
#include "avatar/play/playback.h"
#include "avatar/play/preview.h"
#include "flame/model.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/base/rng.h"
#include "splat/gaussians.h"
#include "splat/io/dataset.h"
#include "splat/render/device.h"

namespace cosplat {
namespace {

constexpr int kOrbitFrames = 120;
constexpr float kAvatarSwingDegrees = 40;

// Random faces: the most that they turn, radians about each axis.
constexpr std::array<float, 3> kRandomNeck{0.1f, 0.3f, 0.05f};
constexpr float kRandomJaw = 0.25f;  // radians, opened

struct RenderOptions {
  std::string model, source, splats, out, drive, flame;
  std::optional<Device> device = Device::kCpu;
  bool orbit = false;
  int resolution = 0;  // 0: as in training
  int random = 0;      // faces by chance
  bool preview = false;
  bool still_bust = false;
  bool quiet = false;
};

DataSplit SplitOf(const RenderOptions& o, const JsonField& run) {
  DataSplit split = SplitFromJson(run);
  if (o.resolution > 0) split.resolution = o.resolution;
  return split;
}

std::string SourceOf(const RenderOptions& o, const JsonField& run) {
  return o.source.empty() ? run["source"].String() : o.source;
}

// Suffix of the image folder for splats other than the run's own.
std::string SuffixOf(const RenderOptions& o) {
  return o.splats.empty() ? "" : "_" + std::filesystem::path(o.splats).stem().string();
}

// Writes frames to a folder or video, with a progress bar. A frame is encoded while the next one is
// rendered.
class Output {
 public:
  Output(const RenderOptions& o,
         size_t total,
         double frames_per_second = kFramesPerSecond,
         std::optional<Sound> sound = {})
      : sink_(o.out, frames_per_second, std::move(sound)),
        bar_("render", int(total), o.quiet),
        quiet_(o.quiet),
        path_(o.out) {}
  void Write(const RenderedImage& image) {
    writing_.wait();  // for the previous frame; rethrows its error
    image_ = image;
    writing_.run([this] { sink_.Write(ToBytes(image_.ToImage())); });
    bar_.Update(++count_, "frames");
  }
  void Finish() {
    writing_.wait();
    sink_.Finish();
    if (!quiet_) std::printf("%d frames: %s\n", sink_.count(), path_.c_str());
  }

 private:
  FrameSink sink_;
  ProgressBar bar_;
  bool quiet_;
  std::string path_;
  int count_ = 0;
  RenderedImage image_;
  tbb::task_group writing_;  // last: its destructor waits for the task, which uses the others
};

void PlayInto(const std::vector<PlaybackFrame>& frames, Player& player, Output&& output) {
  Playback playback(player);
  for (const PlaybackFrame& frame : frames)
    if (const RenderedImage* image = playback.Next(frame)) output.Write(*image);
  if (const RenderedImage* image = playback.Finish()) output.Write(*image);
  output.Finish();
}

void RenderScene(const RenderOptions& o, const JsonField& run) {
  for (const auto& [given, name] :
       {std::pair(!o.drive.empty(), "--drive"), {o.random > 0, "--random"}})
    if (given) throw Error(o.model, name, "is for avatars; this is a scene");
  const auto rasterizer = MakeRasterizer(UsableDevice(o.device));
  const int iteration = SavedIteration(o.model, run);
  Gaussians g = ReadSplatsAloud(o.splats.empty() ? SplatPath(o.model, iteration) : o.splats);
  SortByDegree(g);
  const SceneData scene = LoadSplitScene(SourceOf(o, run), SplitOf(o, run));
  if (o.out.empty())
    RequireDataOfRun(o.model, scene.source, CamerasOf(scene), scene.test.size(), false);
  if (!o.quiet) PrintSkipped(scene.skipped);
  MoveOrigin(g, scene.origin);
  const bool held_out = !scene.test.empty();
  const std::vector<SceneView>& views = held_out ? scene.test : scene.train;
  const auto tape = rasterizer->MakeTape();
  const RenderSettings settings{BackgroundOf(run), g.degree};
  RenderedImage image, half;
  bool shows = false;
  const auto note_if_empty = [&] {
    if (!shows)
      std::fprintf(stderr,
                   "cosplat: %s: no view shows a Gaussian: is it this scene's?\n",
                   (o.splats.empty() ? o.model : o.splats).c_str());
  };
  const auto draw = [&](const Camera& camera) -> const RenderedImage& {
    // Isolated, so that waiting for tiles does not pick up the encoding of the previous frame.
    tbb::this_task_arena::isolate([&] {
      rasterizer->Forward(ViewOf(g),
                          g.basis,
                          o.preview ? HalfResolution(camera) : camera,
                          settings,
                          o.preview ? half : image,
                          *tape);
      if (o.preview) EnlargeTwice(half, camera.width, camera.height, image);
    });
    constexpr float kSeen = 0.98f;  // of the background
    const Buffer<float>& left = (o.preview ? half : image).transmittance;
    shows |= std::any_of(left.begin(), left.end(), [&](float t) { return t < kSeen; });
    return image;
  };
  if (!o.out.empty()) {
    std::vector<Camera> cameras;
    for (const SceneView& view : o.orbit ? scene.train : views) cameras.push_back(view.camera);
    if (o.orbit) cameras = OrbitScene(cameras, kOrbitFrames);
    Output output(o, cameras.size());
    for (const Camera& camera : cameras) output.Write(draw(camera));
    output.Finish();
    return note_if_empty();
  }
  TestImageWriter writer(
      o.model, held_out ? "test" : "train", iteration, settings.background, SuffixOf(o));
  for (const SceneView& view : views)
    writer.Write(draw(view.camera), LoadViewImage(view), {}, LoadIgnored(view));
  writer.Finish();
  note_if_empty();
  if (!o.quiet) std::printf("%zu views: %s\n", views.size(), writer.path().c_str());
}

void RenderAvatarOrbit(const RenderOptions& o,
                       const JsonField& run,
                       const FlameModel& flame,
                       Player& player) {
  const FlameParams rest = ReferenceRoot(run);
  const Camera camera = CameraFromJson(run["reference"]["camera"]);
  PosedAvatar placed;
  player.Pose(rest, placed);
  const std::array<float, 3> center = MiddleOf(player.VerticesOf(placed), flame.vertex_count);
  // FLAME's; trackers keep the head roughly upright in their world.
  constexpr std::array<float, 3> up{0, 1, 0};
  std::vector<PlaybackFrame> frames;
  for (const Camera& c : SwingAround(camera, center, up, kAvatarSwingDegrees, kOrbitFrames))
    frames.push_back({rest, c, BackgroundOf(run)});
  PlayInto(frames, player, Output(o, frames.size()));
}

struct DrivenFaces {
  std::vector<FlameParams> faces;  // a face for each time step, before they are limited
  double frames_per_second = kFramesPerSecond;
  std::optional<Sound> sound;  // of "audio:FILE"
};

DrivenFaces LoadDrivenFaces(const RenderOptions& o,
                            const FlameParams& rest,
                            const FlameModel& flame,
                            const AvatarModel& avatar) {
  LiveSourceOptions options;
  options.rest = rest;
  options.flame = &flame;
  if (avatar.blendshapes) options.blendshapes = &*avatar.blendshapes;
  const Recording recording = LoadDrive(o.drive, options);
  if (!o.quiet) std::printf("%s", UnitLine("track " + o.drive, recording.unit).c_str());
  return {FacesOf(recording), recording.frames_per_second, VideoSoundOf(o.drive)};
}

// Expressions as they are spread over the heads that FLAME was built from, the same ones every
// time.
std::vector<FlameParams> RandomFaces(int count, const FlameParams& rest, const FlameModel& flame) {
  constexpr float kMax = SoftRange::kUsualExpression;
  Rng rng{3};
  std::vector<FlameParams> faces(size_t(count), rest);
  for (FlameParams& face : faces) {
    face.expression.resize(size_t(flame.expression_count));
    for (float& e : face.expression) e = std::clamp(rng.Normal(), -kMax, kMax);
    for (size_t axis = 0; axis < 3; ++axis)
      face.pose[1][axis] += kRandomNeck[axis] * (2 * rng.Uniform() - 1);
    face.pose[2][0] += kRandomJaw * rng.Uniform();
  }
  return faces;
}

void RenderFaces(const RenderOptions& o,
                 const JsonField& run,
                 const FlameModel& flame,
                 Player& player) {
  const FlameParams rest = ReferenceRoot(run);
  DrivenFaces driven;
  if (o.random > 0)
    driven.faces = RandomFaces(o.random, rest, flame);
  else
    driven = LoadDrivenFaces(o, rest, flame, player.avatar());
  const Camera camera = CameraFromJson(run["reference"]["camera"]);
  // As hosts do: another head's motion may go where this one was never seen. Files that do not say
  // what training showed are those of other programs, whose heads are played as they are.
  const auto& trained = player.avatar().trained_range;
  const auto coefficients = size_t(flame.expression_count);
  const SoftRange range(coefficients, trained);
  std::vector<PlaybackFrame> frames;
  size_t softened = 0;
  for (FlameParams& face : driven.faces) {
    face.expression.resize(coefficients, 0.0f);
    if (trained) softened += range.Bring(face);
    frames.push_back({std::move(face), camera, BackgroundOf(run)});
  }
  PlayInto(
      frames, player, Output(o, frames.size(), driven.frames_per_second, std::move(driven.sound)));
  if (softened > 0 && !o.quiet)
    std::printf(
        "%zu of %zu frames went beyond the expressions and turns seen in training, and were "
        "limited\n",
        softened,
        frames.size());
}

void RenderFrames(const RenderOptions& o,
                  const JsonField& run,
                  const FlameModel& flame,
                  AvatarTestImages& renderer) {
  const TrackedVideo video = LoadSplitVideo(SourceOf(o, run), SplitOf(o, run), flame);
  if (o.out.empty())
    RequireDataOfRun(o.model, video.source, CamerasOf(video), video.test.size(), false);
  if (!o.quiet) PrintSkipped(video.skipped);
  const bool held_out = !video.test.empty();
  const std::vector<TrackedFrame>& frames = held_out ? video.test : video.train;
  if (!o.out.empty()) {
    std::vector<PlaybackFrame> sequence;
    for (const TrackedFrame& frame : frames)
      sequence.push_back({frame.params, frame.camera, BackgroundOf(run)});
    return PlayInto(sequence, renderer.player(), Output(o, sequence.size()));
  }
  TestImageWriter writer(
      o.model, held_out ? "test" : "train", SavedIteration(o.model, run), BackgroundOf(run));
  for (const TrackedFrame& frame : frames)
    renderer.WriteTestImage(frame, LoadTrackedImage(video, frame), writer);
  writer.Finish();
  if (!o.quiet) std::printf("%zu frames: %s\n", frames.size(), writer.path().c_str());
}

void RenderAvatar(const RenderOptions& o, const JsonField& run) {
  if (!o.splats.empty()) throw Error(o.model, "--splats", "is for scenes; this is an avatar");
  const Device device = UsableDevice(o.device);
  auto [model, flame] = LoadPosable(o.model + "/avatar.glb", &run, o.flame);
  if (o.still_bust) HoldBustStill(model);
  AvatarTestImages renderer(std::move(model), flame, {o.preview, AvatarRendererOn(device)});
  if (o.orbit) {
    RenderAvatarOrbit(o, run, flame, renderer.player());
  } else if (!o.drive.empty() || o.random > 0) {
    RenderFaces(o, run, flame, renderer.player());
  } else {
    RenderFrames(o, run, flame, renderer);
  }
}

void Render(const RenderOptions& o) {
  const JsonField run = ReadRun(o.model);
  if (o.out.empty() && (o.orbit || !o.drive.empty() || o.random > 0))
    throw Error("--out", "is needed: a folder or a file that ends in .mp4");
  if (o.out.empty() && o.preview)
    throw Error("--preview", "needs --out: test views are measured at full size");
  RequireSplats(run);
  if (!o.out.empty()) {
    RefuseDataFolder("-o", o.out, SourceOf(o, run), o.model);
    RefuseInput("-o", o.out, o.drive.starts_with("audio:") ? o.drive.substr(6) : o.drive);
    for (const char* results : {"test", "train", "point_cloud"})
      if (IsInside(o.out, o.model + "/" + results))
        throw Error("-o " + o.out, "is where the run keeps its results: choose another folder");
  }
  if (run["kind"].String() == "avatar") {
    RenderAvatar(o, run);
  } else {
    RenderScene(o, run);
  }
}

}  // namespace

void RenderVideo(const std::string& model,
                 VideoOf what,
                 const std::string& drive,
                 const std::string& out,
                 std::optional<Device> device,
                 bool quiet) {
  RenderOptions o;
  o.model = model;
  o.out = out;
  o.device = device;
  o.quiet = quiet;
  if (what == VideoOf::kSequence) o.drive = drive;
  o.orbit = what == VideoOf::kOrbit;
  Render(o);
}

void AddRender(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("render", "render test views, an orbit, or a driving sequence");
  const auto o = std::make_shared<RenderOptions>();
  command->add_option("-m,--model_path", o->model, "a trained model's folder")->required();
  command->add_option("-s,--source_path", o->source, "data set; the one trained on if not given");
  command->add_option("--splats",
                      o->splats,
                      "splat file in place of a scene's own, for `metrics` too (docs/files.md)");
  command->add_option(
      "-o,--out", o->out, "folder or .mp4; test views go into the model's folder if not given");
  auto* orbit = command->add_flag("--orbit", o->orbit, "circle the subject");
  auto* drive =
      command
          ->add_option("--drive",
                       o->drive,
                       "play an avatar with the motion of this tracked video, .npz, landmarks "
                       "file with blendshape scores, .csv of Live Link Face, or of audio:FILE, "
                       "a voice")
          ->excludes(orbit);
  command
      ->add_option("--random",
                   o->random,
                   "show an avatar with this many random expressions: whether it holds where its "
                   "video did not go")
      ->check(CLI::Range(1, 100000))
      ->excludes(orbit)
      ->excludes(drive);
  command->add_option("--flame", o->flame, "FLAME model file; the one trained with if not given");
  command->add_option("-r,--resolution", o->resolution, "divide the images' size by this")
      ->check(CLI::Range(0, 64));
  command->add_flag("--still-bust",
                    o->still_bust,
                    "hold an avatar's shoulders still instead of following the head");
  command->add_flag(
      "--preview", o->preview, "render at half the resolution and enlarge: faster and softer");
  AddDevice(*command, o->device, "where to render; auto: on an NVIDIA GPU if there is one");
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { Render(*o); });
}

}  // namespace cosplat
