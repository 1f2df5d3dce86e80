#include "apps/cosplat/export_subject.h"

#include <algorithm>
#include <filesystem>

#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "avatar/io/avatar_file.h"
#include "avatar/io/gaussian_avatars.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/color_weights.h"
#include "splat/io/splat_file.h"
#include "splat/train/prune/importance.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

std::vector<Camera> TrainingCameras(const SceneData& data) {
  std::vector<Camera> cameras;
  for (const SceneView& view : data.train) cameras.push_back(view.camera);
  return cameras;
}

ExportSubject LoadImported(const ExportSource& source) {
  ExportSubject subject;
  subject.path = source.splats;
  subject.imported = LoadGaussianAvatar(source.splats, source.flame, source.data);
  subject.gaussians = RestPose(subject.imported->model);
  subject.is_avatar = true;
  return subject;
}

ExportSubject LoadRun(const ExportSource& source) {
  const JsonField run = ReadRun(source.model);
  RequireSplats(run);
  ExportSubject subject;
  subject.is_avatar = run["kind"].String() == "avatar";
  if (subject.is_avatar && !source.splats.empty())
    throw Error(source.model, "--splats", "is for scenes; this is an avatar");
  if (subject.is_avatar && source.measure)
    throw Error(source.model, "--measure", "is for scenes; an avatar's files hold it at rest only");
  subject.path = source.splats.empty() ? SplatPath(source.model, SavedIteration(source.model, run))
                                       : source.splats;
  subject.gaussians = ReadSplatsAloud(subject.path);
  subject.background = BackgroundOf(run);
  if (!subject.is_avatar && (source.views || source.measure))
    subject.data = LoadSplitScene(source.data.empty() ? run["source"].String() : source.data,
                                  SplitFromJson(run));
  if (!subject.is_avatar) MoveOrigin(subject.gaussians, *SplitFromJson(run).origin);
  if (source.measure && subject.data.test.empty())
    throw Error(source.model, "--measure", "the run has no held-out views: train with --eval");
  return subject;
}

// Writes what `render`, `metrics` and `play` read besides avatar.glb: run.json, cameras.json and
// the splats at rest, as of the iteration in the splats' path (iteration_N), else 0. The frames
// held out are those of the data set's own split. Throws Error as LoadDrivingSequence does.
void WriteImportedRun(const std::string& folder,
                      const ExportSource& source,
                      const AvatarModel& avatar) {
  const TrackedVideo video = LoadDrivingSequence(source.data);
  const int iteration =
      std::max(0, IterationIn(fs::absolute(source.splats).parent_path().filename().string()));
  DataSplit split;
  split.eval = true;
  const Json run{{"kind", "avatar"},
                 {"source", fs::absolute(source.data).string()},
                 {"flame", fs::absolute(source.flame).string()},
                 {"imported", fs::absolute(source.splats).string()},
                 {"split", ToJson(split)},
                 {"iterations", iteration},
                 {"degree", avatar.gaussians.degree},
                 {"basis", ToString(avatar.gaussians.basis)},
                 {"seed", nullptr},
                 {"background", avatar.background},
                 {"reference", ReferenceView(video)},
                 {"version", COSPLAT_VERSION}};
  MakeDirectories(folder);
  WriteCamerasJson(folder + "/cameras.json", CamerasOf(video));
  SaveSplats(folder, iteration, RestPose(avatar));
  WriteFileAtomically(folder + "/run.json", run.dump(2) + "\n");
}

}  // namespace

ExportSubject LoadExportSubject(const ExportSource& source) {
  ExportSubject subject;
  if (!source.model.empty()) {
    subject = LoadRun(source);
  } else if (SplatLayoutOf(source.splats) == SplatLayout::kPly &&
             IsGaussianAvatarPly(source.splats)) {
    subject = LoadImported(source);
  } else {
    subject.path = source.splats;
    subject.gaussians = ReadSplatsAloud(source.splats);
  }
  // From FLAME's axes, which are glTF's, to those of scenes: the turn is its own inverse.
  if (subject.is_avatar) TurnToGltfAxes(subject.gaussians);
  return subject;
}

std::vector<float> SignificanceOf(const ExportSubject& subject) {
  return subject.data.train.empty()
             ? SizeSignificance(subject.gaussians)
             : GlobalSignificance(subject.gaussians, TrainingCameras(subject.data));
}

std::vector<float> SeenBandsOf(const ExportSubject& subject) {
  if (subject.data.train.empty()) return {};
  Gaussians g = subject.gaussians;
  TruncateDegree(kMaxSplatFileDegree, g);
  return SeenBands(g, TrainingCameras(subject.data));
}

void ExportGlb(const std::string& path, const ExportSubject& subject, bool truncate_degree) {
  if (subject.imported)
    return WriteAvatarGlb(
        path, subject.imported->model, &subject.imported->flame, {false, truncate_degree});
  if (subject.is_avatar)
    throw Error(
        subject.path, "--glb", "is only for scenes; an avatar's run already has avatar.glb");
  WriteSceneGlb(path, subject.gaussians, truncate_degree);
}

void ExportRun(const std::string& folder,
               const ExportSource& source,
               const ExportSubject& subject,
               bool truncate_degree) {
  if (!subject.imported)
    throw Error(subject.path, "--run", "is for point clouds of GaussianAvatars");
  if (source.data.empty())
    throw Error("--run", "needs -s: the data set whose frames are rendered and measured");
  WriteImportedRun(folder, source, subject.imported->model);
  ExportGlb(folder + "/avatar.glb", subject, truncate_degree);
}

}  // namespace cosplat
