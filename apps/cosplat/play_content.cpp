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
#include "flame/model.h"
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

// At rest before the camera. `avatar` has all but its rest.
Content ContentOf(Content::Avatar loaded, const JsonField* run) {
  Content content;
  Content::Avatar& avatar = content.avatar.emplace(std::move(loaded));
  content.background = avatar.model.background;
  avatar.rest = run ? ReferenceRoot(*run) : RestRoot(avatar.model, avatar.flame);
  content.start =
      run ? AsFilmed(avatar, *run) : viewer::BeforeHead(HeadVertices(avatar), avatar.rest.pose[0]);
  return content;
}

// run: the run whose folder contains the avatar, or null.
Content LoadAvatar(const std::string& glb, const JsonField* run, const std::string& flame) {
  Content::Avatar avatar;
  avatar.model = ReadAvatarGlb(glb);
  avatar.flame = LoadFlameOfRun(avatar.model, glb, run, flame);
  AttachMesh(avatar.model, avatar.flame);
  return ContentOf(std::move(avatar), run);
}

Content LoadGaussianAvatar(const std::string& path, const std::string& flame) {
  if (flame.empty())
    throw Error(path, "--flame", "is needed: the FLAME model that it was trained with");
  Content::Avatar avatar;
  avatar.flame = LoadFlameModel(flame);
  avatar.model = ReadGaussianAvatar(path, avatar.flame);
  avatar.flame = FlameOf(avatar.model, std::move(avatar.flame));
  return ContentOf(std::move(avatar), nullptr);
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
  if (run["kind"].String() == "avatar") return LoadAvatar(folder + "/avatar.glb", &run, flame);
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
    return LoadGaussianAvatar(path, flame);
  if (layout != SplatLayout::kGlb || !SummarizeGlb(path).avatar) return LoadSplatsOf(path);
  const std::string folder = fs::absolute(path).parent_path().string();
  if (!fs::exists(folder + "/run.json")) return LoadAvatar(path, nullptr, flame);
  const JsonField run = ReadRun(folder);
  return LoadAvatar(path, &run, flame);
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

namespace {

// What a drive needs of an avatar.
struct DrivenHead {
  FlameParams rest;
  FlameModel flame;
  std::optional<BlendshapeMap> blendshapes;
  std::optional<TrainedRange> trained;
};

void DriveHead(
    Session& session, const DrivenHead& head, const std::string& drive, double fps, bool verbose) {
  LiveSourceOptions options;
  options.rest = head.rest;
  options.flame = &head.flame;
  if (head.blendshapes) options.blendshapes = &*head.blendshapes;
  options.frames_per_second = fps;
  options.program = ThisProgram();
  if (IsLiveDrive(drive)) {
    FlameParams rest = head.rest;
    rest.expression.assign(size_t(head.flame.expression_count), 0);
    std::unique_ptr<LiveSource> source = OpenLiveSource(drive, options);
    if (verbose) source = std::make_unique<VerboseSource>(std::move(source));
    session.SetLive(
        std::make_unique<viewer::LiveFace>(std::move(source), std::move(rest), head.trained));
  } else {
    if (verbose) throw Error("--verbose", "is for live drives; '" + drive + "' is a recording");
    const Recording recording = LoadDrive(drive, options);
    if (!recording.note.empty()) PrintNotes({drive + ": " + recording.note});
    session.SetSequence(
        fs::path(drive).filename().string(), FacesOf(recording), recording.frames_per_second);
  }
  session.drive = drive;
}

}  // namespace

std::function<void(Session& session, const std::string& drive)> DriverOf(
    const Content::Avatar& avatar, double fps, bool verbose) {
  const auto head = std::make_shared<DrivenHead>(
      DrivenHead{avatar.rest, avatar.flame, avatar.model.blendshapes, avatar.model.trained_range});
  return [=](Session& session, const std::string& drive) {
    DriveHead(session, *head, drive, fps, verbose);
  };
}

void DriveSession(
    Session& session, const Content& content, const std::string& drive, double fps, bool verbose) {
  if (!content.avatar) throw Error(content.title, "--drive", "is for avatars; this is a scene");
  DriverOf(*content.avatar, fps, verbose)(session, drive);
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
