#include "apps/cosplat/export_subject.h"

#include "apps/cosplat/run/imported_run.h"
#include "apps/cosplat/run/read_splats.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "avatar/io/avatar_file.h"
#include "avatar/io/gaussian_avatars.h"
#include "avatar/model/avatar_mesh.h"
#include "flame/model.h"
#include "splat/base/error.h"
#include "splat/io/color_weights.h"
#include "splat/io/splat_file.h"
#include "splat/train/prune/importance.h"

namespace cosplat {
namespace {

std::vector<Camera> TrainingCameras(const SceneData& data) {
  std::vector<Camera> cameras;
  for (const SceneView& view : data.train) cameras.push_back(view.camera);
  return cameras;
}

ExportSubject LoadImported(const ExportSource& source) {
  if (source.flame.empty())
    throw Error(source.splats, "--flame", "is needed: the FLAME model that it was trained with");
  FlameModel flame = LoadFlameModel(source.flame);
  AvatarModel model = ReadGaussianAvatar(source.splats, flame, source.data);
  flame = FlameOf(model, std::move(flame));
  ExportSubject subject;
  subject.path = source.splats;
  subject.gaussians = RestPose(model);
  subject.is_avatar = true;
  subject.imported = {std::move(model), std::move(flame)};
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
  WriteImportedRun(folder, {source.splats, source.data, source.flame}, subject.imported->model);
  ExportGlb(folder + "/avatar.glb", subject, truncate_degree);
}

}  // namespace cosplat
