#include "apps/cosplat/play_content.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "apps/cosplat/run/head_model.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/verbose_source.h"
#include "apps/cosplat/run/voice_drive.h"
#include "apps/viewer/orbit_camera.h"
#include "avatar/io/avatar_file.h"
#include "avatar/io/gaussian_avatars.h"
#include "avatar/model/avatar_mesh.h"
#include "splat/base/error.h"
#include "splat/base/process.h"
#include "splat/io/cameras_json.h"
#include "splat/io/splat_file.h"
#include "splat/levels/levels_file.h"

namespace cosplat {
namespace fs = std::filesystem;

using viewer::Content;
using viewer::Session;
using viewer::StartView;

namespace {

std::vector<float> HeadVertices(const Content::Avatar& avatar) {
  const AvatarModel& model = avatar.model;
  AvatarPoser poser(avatar.flame, model.shape, model.static_offset, model.bust);
  std::vector<float> vertices;
  poser.Forward(poser.ParametersFor(avatar.rest), vertices);
  vertices.resize(3 * size_t(avatar.flame.vertex_count));  // drops the bust's, which come last
  return vertices;
}

// The first training frame's camera, orbiting the centre of the head.
StartView AsFilmed(const Content::Avatar& avatar, const JsonField& run) {
  const StartView front = viewer::BeforeHead(HeadVertices(avatar), avatar.rest.pose[0]);
  const Camera camera = CameraFromJson(run["reference"]["camera"]);
  const std::array<float, 9>& r = camera.rotation;
  return {camera, front.center, {-r[3], -r[4], -r[5]}};
}

// At rest before the camera. run: the run whose folder contains the avatar, or null.
Content ContentOf(PosableAvatar loaded, const JsonField* run) {
  Content content;
  Content::Avatar& avatar =
      content.avatar.emplace(Content::Avatar{std::move(loaded.model), std::move(loaded.flame), {}});
  content.background = avatar.model.background;
  avatar.rest = run ? ReferenceRoot(*run) : RestRoot(avatar.model, avatar.flame);
  content.start =
      run ? AsFilmed(avatar, *run) : viewer::BeforeHead(HeadVertices(avatar), avatar.rest.pose[0]);
  return content;
}

Content LoadSplatsOf(const std::string& path) {
  Content content;
  content.scene = ReadSplatsAloud(path);
  content.background = {0, 0, 0};
  content.start = viewer::BeforeSplats(path, content.scene);
  return content;
}

Content LoadRunScene(const std::string& folder, const JsonField& run) {
  Content content = LoadSplatsOf(SplatPath(folder, SavedIteration(folder, run)));
  content.background = BackgroundOf(run);
  std::vector<Camera> cameras;
  if (fs::exists(folder + "/cameras.json"))
    for (const NamedCamera& named : ReadCamerasJson(folder + "/cameras.json"))
      cameras.push_back(named.camera);
  if (cameras.empty()) return content;
  MoveOrigin(content.scene, *SplitFromJson(run).origin);  // of the cameras
  const float near_plane = content.start.camera.near_plane;
  content.start = viewer::AtCamera(cameras);
  content.start.camera.near_plane = near_plane;
  return content;
}

Content LoadRunContent(const std::string& folder, const std::string& flame) {
  const JsonField run = ReadRun(folder);
  RequireSplats(run);
  if (run["kind"].String() == "avatar")
    return ContentOf(LoadPosable(folder + "/avatar.glb", &run, flame), &run);
  return LoadRunScene(folder, run);
}

Content LoadFile(const std::string& path, const std::string& flame) {
  if (IsLevelsFile(path)) {
    Content content;
    content.levels = OpenLevels(path);
    content.background = {0, 0, 0};
    Gaussians coarsest = content.levels->Coarsest();
    // Those that stand for few small ones far apart are faint, but not invisible.
    coarsest.values[kOpacityLogit].assign(coarsest.size(), 0.0f);
    content.start = viewer::BeforeSplats(path, coarsest);
    return content;
  }
  const SplatLayout layout = SplatLayoutOf(path);
  if (layout == SplatLayout::kPly && IsGaussianAvatarPly(path))
    return ContentOf(LoadGaussianAvatar(path, flame), nullptr);
  if (layout != SplatLayout::kGlb || !SummarizeGlb(path).avatar) return LoadSplatsOf(path);
  const std::string folder = fs::absolute(path).parent_path().string();
  if (!fs::exists(folder + "/run.json"))
    return ContentOf(LoadPosable(path, nullptr, flame), nullptr);
  const JsonField run = ReadRun(folder);
  return ContentOf(LoadPosable(path, &run, flame), &run);
}

}  // namespace

Content LoadContent(const std::string& model, const std::string& flame) {
  const bool run = fs::is_directory(model) && SplatLayoutOf(model) != SplatLayout::kSog;
  Content content = run ? LoadRunContent(model, flame) : LoadFile(model, flame);
  if (!content.avatar && !flame.empty())
    throw Error(model, "--flame", "is for avatars; this is a scene");
  const fs::path path = fs::absolute(model).lexically_normal();
  content.title = (path.has_filename() ? path : path.parent_path()).filename().string();
  return content;
}

std::function<void(Session& session, const std::string& drive)> DriverOf(const Content& content,
                                                                         double fps,
                                                                         bool verbose) {
  if (!content.avatar)
    return [title = content.title](Session&, const std::string&) {
      throw Error(title, "--drive", "is for avatars; this is a scene");
    };
  const auto flame = std::make_shared<const FlameModel>(content.avatar->flame);
  const FlameParams rest = content.avatar->rest;
  const auto blendshapes = content.avatar->model.blendshapes;
  const auto trained = content.avatar->model.trained_range;
  return [=](Session& session, const std::string& drive) {
    LiveSourceOptions options;
    options.rest = rest;
    options.flame = flame.get();
    if (blendshapes) options.blendshapes = &*blendshapes;
    options.frames_per_second = fps;
    options.program = ThisProgram();
    if (IsLiveDrive(drive)) {
      FlameParams neutral = rest;
      neutral.expression.assign(size_t(flame->expression_count), 0);
      std::unique_ptr<LiveSource> source = OpenLiveSource(drive, options);
      if (verbose) source = std::make_unique<VerboseSource>(std::move(source));
      session.SetLive(
          std::make_unique<viewer::LiveFace>(std::move(source), std::move(neutral), trained));
    } else {
      if (verbose) throw Error("--verbose", "is for live drives; '" + drive + "' is a recording");
      const Recording recording = LoadDrive(drive, options);
      session.SetSequence(FacesOf(recording), recording.frames_per_second);
    }
    session.drive = drive;
  };
}

PictureSize ParsePictureSize(const std::string& text) {
  constexpr int kMaxSide = 8192;
  PictureSize size;
  char rest = 0;
  const int read = std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &rest);
  if (read != 2 || std::min(size.width, size.height) < 1 ||
      std::max(size.width, size.height) > kMaxSide)
    throw Error("--size", "is '" + text + "', expected WIDTHxHEIGHT such as 640x480");
  return size;
}

}  // namespace cosplat
