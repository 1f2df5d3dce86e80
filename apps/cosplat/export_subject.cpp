#include "apps/cosplat/export_subject.h"

#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "avatar/io/avatar_file.h"
#include "avatar/model/avatar_mesh.h"
#include "flame/io/model_file.h"
#include "splat/base/error.h"
#include "splat/io/splat_file.h"
#include "splat/train/importance.h"

namespace cosplat {
namespace {

std::string Or(const std::string& given, const std::string& otherwise) {
  return given.empty() ? otherwise : given;
}

// A scene, or a splat file without any further data; `data` then has no views.
class SceneSplats : public ExportSubject {
 public:
  SceneSplats(const std::string& path, SceneData data, const std::array<float, 3>& background)
      : ExportSubject(path), data_(std::move(data)), background_(background) {}
  QuantisedSplats Quantised(const VqSettings& settings) const override {
    std::vector<Camera> cameras;
    for (const SceneView& view : data_.train) cameras.push_back(view.camera);
    return Quantise(
        gaussians(),
        cameras.empty() ? SizeSignificance(gaussians()) : GlobalSignificance(gaussians(), cameras),
        settings);
  }
  TestViews AsTrained() override { return ViewsOfScene(gaussians(), data_, background_); }
  TestViews FromFile(const std::string& path) override {
    from_file_ = ReadSplats(path);
    return ViewsOfScene(from_file_, data_, background_);
  }

 private:
  SceneData data_;
  std::array<float, 3> background_;
  Gaussians from_file_;
};

class AvatarSplats : public ExportSubject {
 public:
  AvatarSplats(const std::string& path, const JsonField& run, const ExportSource& source)
      : ExportSubject(path),
        model_(ReadAvatarGlb(source.model + "/avatar.glb")),
        background_(BackgroundOf(run)) {
    if (!source.measure) return;
    flame_ = FlameOf(model_, LoadFlameModel(Or(source.flame, run["flame"].String())));
    AttachMesh(model_, flame_);
    video_ = LoadSplitVideo(Or(source.data, run["source"].String()), SplitFromJson(run), flame_);
  }
  bool is_avatar() const override { return true; }
  QuantisedSplats Quantised(const VqSettings& settings) const override {
    if (model_.gaussians.corrections > 0)
      throw Error("--vq",
                  "cannot hold the avatar's " + std::to_string(model_.gaussians.corrections) +
                      " corrections: train it without --corrections");
    Gaussians g = model_.gaussians;
    ConvertBasis(g, Basis::kSh);
    QuantisedSplats splats = Quantise(g, SizeSignificance(g), settings);
    AddEmbedding(model_.embedding, splats);
    return splats;
  }
  TestViews AsTrained() override { return ViewsOfAvatar(model_, flame_, video_, background_); }
  TestViews FromFile(const std::string& path) override {
    AvatarModel model = model_;
    ReadQuantisedAvatar(path, model);
    return ViewsOfAvatar(model, flame_, video_, background_);
  }

 private:
  AvatarModel model_;
  FlameModel flame_;
  TrackedVideo video_;
  std::array<float, 3> background_;
};

std::unique_ptr<ExportSubject> LoadRun(const ExportSource& source) {
  const Json json = ReadRun(source.model);
  const JsonField run(source.model + "/run.json", json);
  RequireSplats(run);
  const bool avatar = run["kind"].String() == "avatar";
  if (avatar && !source.splats.empty())
    throw Error(source.model, "--splats", "is for scenes; this is an avatar");
  std::string path = source.splats;
  if (path.empty()) path = SplatPath(source.model, SavedIteration(source.model, run));
  if (avatar) return std::make_unique<AvatarSplats>(path, run, source);
  SceneData data;
  if (source.quantise || source.measure)
    data = LoadSplitScene(Or(source.data, run["source"].String()), SplitFromJson(run));
  return std::make_unique<SceneSplats>(path, std::move(data), BackgroundOf(run));
}

}  // namespace

ExportSubject::ExportSubject(const std::string& path) : path_(path), gaussians_(ReadSplats(path)) {}

std::unique_ptr<ExportSubject> LoadExportSubject(const ExportSource& source) {
  if (source.model.empty())
    return std::make_unique<SceneSplats>(source.splats, SceneData(), std::array<float, 3>());
  std::unique_ptr<ExportSubject> subject = LoadRun(source);
  if (source.measure && subject->AsTrained().count == 0)
    throw Error(source.model, "--measure", "the run has no held-out views: train with --eval");
  return subject;
}

}  // namespace cosplat
