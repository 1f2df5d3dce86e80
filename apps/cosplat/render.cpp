// cosplat render: a trained model's test views, an orbit, or an avatar driven by a sequence.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "apps/cosplat/camera_path.h"
#include "apps/cosplat/commands.h"
#include "apps/cosplat/frame_sink.h"
#include "apps/cosplat/progress_bar.h"
#include "apps/cosplat/run_folder.h"
#include "apps/cosplat/test_images.h"
#include "avatar/avatar_file.h"
#include "avatar/player.h"
#include "avatar/silhouette.h"
#include "flame/io/model_file.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/dataset.h"
#include "splat/io/ply.h"

namespace cosplat {
namespace {

constexpr int kOrbitFrames = 120;
constexpr float kAvatarSwingDegrees = 40;

struct Options {
  std::string model, source, out, drive, flame;
  bool orbit = false;
  int resolution = 0;  // 0: as trained
  bool quiet = false;
};

std::array<float, 3> BackgroundOf(const JsonField& run) {
  const float c = run.raw().value("white_background", false) ? 1.0f : 0.0f;
  return {c, c, c};
}

int ResolutionOf(const Options& o, const JsonField& run) {
  return o.resolution > 0 ? o.resolution : run["resolution"].Integer();
}

std::string SourceOf(const Options& o, const JsonField& run) {
  return o.source.empty() ? run["source"].String() : o.source;
}

// Frames to a folder or video, with a progress bar.
class Output {
 public:
  Output(const Options& o, size_t total)
      : sink_(o.out), bar_("render", int(total)), quiet_(o.quiet), path_(o.out) {}
  void Write(const RenderedImage& image) {
    sink_.Write(ToBytes(image.ToImage()));
    bar_.Update(sink_.count(), "frames");
  }
  void Finish() {
    sink_.Finish();
    if (!quiet_) std::printf("%d frames: %s\n", sink_.count(), path_.c_str());
  }

 private:
  FrameSink sink_;
  ProgressBar bar_;
  bool quiet_;
  std::string path_;
};

void RenderScene(const Options& o, const JsonField& run) {
  if (!o.drive.empty()) throw Error(o.model, "--drive", "is for avatars; this is a scene");
  const int iteration = LatestIteration(o.model);
  const Gaussians g = ReadPly(SplatPath(o.model, iteration));
  SceneOptions scene_options{
      ResolutionOf(o, run), run.raw().value("eval", false), run.raw().value("fold", false)};
  const SceneData scene = LoadScene(SourceOf(o, run), scene_options);
  std::vector<Camera> cameras;
  for (const SceneView& view : scene.train) cameras.push_back(view.camera);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  const RenderSettings settings{BackgroundOf(run), g.degree};
  RenderedImage image;
  if (o.orbit) {
    Output output(o, kOrbitFrames);
    for (const Camera& camera : OrbitScene(cameras, kOrbitFrames)) {
      rasterizer->Forward(ViewOf(g), g.basis, camera, settings, image, *tape);
      output.Write(image);
    }
    return output.Finish();
  }
  const std::vector<SceneView>& views = scene.test.empty() ? scene.train : scene.test;
  if (!o.out.empty()) {
    Output output(o, views.size());
    for (const SceneView& view : views) {
      rasterizer->Forward(ViewOf(g), g.basis, view.camera, settings, image, *tape);
      output.Write(image);
    }
    return output.Finish();
  }
  TestImageWriter writer(o.model, iteration, settings.background);
  for (const SceneView& view : views) {
    rasterizer->Forward(ViewOf(g), g.basis, view.camera, settings, image, *tape);
    writer.Write(image, LoadViewImage(view));
  }
  writer.Finish();
  if (!o.quiet) std::printf("%zu views: %s/test\n", views.size(), o.model.c_str());
}

FlameParams ReferenceRoot(const JsonField& run) {
  FlameParams p;
  const std::vector<float> r = run["reference"]["rotation"].Numbers(3);
  const std::vector<float> t = run["reference"]["translation"].Numbers(3);
  std::copy(r.begin(), r.end(), p.pose[0].begin());
  std::copy(t.begin(), t.end(), p.translation.begin());
  return p;
}

// The centre of the posed head and its own upward direction.
void HeadFrame(const Player& player,
               const FlameModel& flame,
               std::array<float, 3>& center,
               std::array<float, 3>& up) {
  center = {0, 0, 0};
  const std::vector<float>& v = player.vertices();
  for (int i = 0; i < flame.vertex_count; ++i)
    for (int k = 0; k < 3; ++k) center[k] += v[3 * size_t(i) + k] / float(flame.vertex_count);
  up = {0, 1, 0};  // FLAME's own; trackers keep the head roughly upright in their world
}

void RenderAvatarOrbit(const Options& o,
                       const JsonField& run,
                       const FlameModel& flame,
                       Player& player) {
  const FlameParams rest = ReferenceRoot(run);
  const Camera camera = CameraFromJson(run["reference"]["camera"]);
  RenderedImage image;
  player.RenderOver(rest, camera, BackgroundOf(run), image);
  std::array<float, 3> center{}, up{};
  HeadFrame(player, flame, center, up);
  Output output(o, kOrbitFrames);
  for (const Camera& c : SwingAround(camera, center, up, kAvatarSwingDegrees, kOrbitFrames)) {
    player.RenderOver(rest, c, BackgroundOf(run), image);
    output.Write(image);
  }
  output.Finish();
}

void RenderDriven(const Options& o, const JsonField& run, Player& player) {
  TrackedVideo sequence = LoadTrackedVideo(o.drive, {-1, 1, false});
  std::vector<FlameParams> frames;
  for (const auto* list : {&sequence.train, &sequence.test})
    for (const TrackedFrame& frame : *list) frames.push_back(frame.params);
  const Camera camera = CameraFromJson(run["reference"]["camera"]);
  RenderedImage image;
  Output output(o, frames.size());
  for (const FlameParams& frame : Retarget(frames, ReferenceRoot(run))) {
    player.RenderOver(frame, camera, BackgroundOf(run), image);
    output.Write(image);
  }
  output.Finish();
}

void RenderTestFrames(const Options& o, const JsonField& run, Player& player) {
  const TrackedVideo video = LoadTrackedVideo(
      SourceOf(o, run), {run["test_frames"].Integer(), ResolutionOf(o, run), true});
  const std::vector<TrackedFrame>& frames = video.test.empty() ? video.train : video.test;
  const std::array<float, 3> background = BackgroundOf(run);
  RenderedImage image;
  if (!o.out.empty()) {
    Output output(o, frames.size());
    for (const TrackedFrame& frame : frames) {
      player.RenderOver(frame.params, frame.camera, background, image);
      output.Write(image);
    }
    return output.Finish();
  }
  const CanonicalMesh& mesh = player.avatar().mesh;
  const MeshTopology topology = BuildTopology("avatar", mesh.faces, int(mesh.vertices.size() / 3));
  TestImageWriter writer(o.model, LatestIteration(o.model), background);
  for (const TrackedFrame& frame : frames) {
    player.RenderOver(frame.params, frame.camera, background, image);
    const std::array<int, 4> box =
        MouthBox(player.vertices(), mesh.vertices, topology, frame.camera);
    const Rectangle mouth{box[0], box[1], box[2], box[3]};
    writer.Write(image, LoadTrackedImage(video, frame), mouth.width > 0 ? &mouth : nullptr);
  }
  writer.Finish();
  if (!o.quiet) std::printf("%zu frames: %s/test\n", frames.size(), o.model.c_str());
}

void RenderAvatar(const Options& o, const JsonField& run) {
  const FlameModel flame = LoadFlameModel(o.flame.empty() ? run["flame"].String() : o.flame);
  AvatarModel model = ReadAvatarGlb(o.model + "/avatar.glb");
  AttachMesh(model, flame);
  Player player(std::move(model), flame);
  if (o.orbit) {
    RenderAvatarOrbit(o, run, flame, player);
  } else if (!o.drive.empty()) {
    RenderDriven(o, run, player);
  } else {
    RenderTestFrames(o, run, player);
  }
}

void Render(const Options& o) {
  const Json json = ReadRun(o.model);
  const JsonField run(o.model + "/run.json", json);
  if (o.out.empty() && (o.orbit || !o.drive.empty()))
    throw Error("", "--out", "is needed: a folder or a file that ends in .mp4");
  if (run["kind"].String() == "avatar") {
    RenderAvatar(o, run);
  } else {
    RenderScene(o, run);
  }
}

}  // namespace

void AddRender(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("render", "render test views, an orbit, or a driving sequence");
  const auto o = std::make_shared<Options>();
  command->add_option("-m,--model_path", o->model, "a trained model's folder")->required();
  command->add_option("-s,--source_path", o->source, "data set; the one trained on if not given");
  command->add_option(
      "-o,--out", o->out, "folder or .mp4; test views go into the model's folder if not given");
  auto* orbit = command->add_flag("--orbit", o->orbit, "circle the subject");
  command
      ->add_option("--drive", o->drive, "play an avatar with this tracked video's or .npz's motion")
      ->excludes(orbit);
  command->add_option("--flame", o->flame, "FLAME model file; the one trained with if not given");
  command->add_option("-r,--resolution", o->resolution, "divide the pictures' size by this")
      ->check(CLI::Range(0, 64));
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { Render(*o); });
}

}  // namespace cosplat
