#include "apps/cosplat/export_subject.h"

#include "apps/cosplat/run/imported_run.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "avatar/io/avatar_file.h"
#include "avatar/io/gaussian_avatars.h"
#include "avatar/model/avatar_mesh.h"
#include "flame/io/model_file.h"
#include "splat/base/error.h"
#include "splat/io/seen_bands.h"
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
      : ExportSubject(path, ReadSplats(path)), data_(std::move(data)), background_(background) {}
  std::vector<float> Significance() const override {
    return data_.train.empty() ? ExportSubject::Significance()
                               : GlobalSignificance(gaussians(), Cameras());
  }
  std::vector<float> Seen() const override {
    if (data_.train.empty()) return {};
    Gaussians g = gaussians();
    TruncateDegree(kMaxSplatFileDegree, g);
    return SeenBands(g, Cameras());
  }
  QuantisedSplats Quantised(const VqSettings& settings) const override {
    return Quantise(gaussians(), Significance(), settings);
  }
  void WriteGlb(const std::string& path, bool truncate_degree) const override {
    WriteSceneGlb(path, gaussians(), truncate_degree);
  }
  TestViews AsTrained() override { return ViewsOfScene(gaussians(), data_, background_); }
  TestViews FromFile(const std::string& path) override {
    from_file_ = ReadSplats(path);
    return ViewsOfScene(from_file_, data_, background_);
  }

 private:
  std::vector<Camera> Cameras() const {
    std::vector<Camera> cameras;
    for (const SceneView& view : data_.train) cameras.push_back(view.camera);
    return cameras;
  }

  SceneData data_;
  std::array<float, 3> background_;
  Gaussians from_file_;
};

QuantisedSplats QuantisedAvatar(const AvatarModel& model, const VqSettings& settings) {
  if (model.gaussians.corrections > 0)
    throw Error("--vq",
                "cannot hold the avatar's " + std::to_string(model.gaussians.corrections) +
                    " corrections: train it without --corrections");
  Gaussians g = model.gaussians;
  ConvertBasis(g, Basis::kSh);
  QuantisedSplats splats = Quantise(g, SizeSignificance(g), settings);
  AddEmbedding(model.embedding, splats);
  return splats;
}

class AvatarSplats : public ExportSubject {
 public:
  AvatarSplats(const std::string& path, const JsonField& run, const ExportSource& source)
      : ExportSubject(path, ReadSplats(path)),
        folder_(source.model),
        model_(ReadAvatarGlb(source.model + "/avatar.glb")),
        background_(BackgroundOf(run)) {
    if (!source.measure) return;
    flame_ = FlameOf(model_, LoadFlameModel(Or(source.flame, run["flame"].String())));
    AttachMesh(model_, flame_);
    video_ = LoadSplitVideo(Or(source.data, run["source"].String()), SplitFromJson(run), flame_);
  }
  bool is_avatar() const override { return true; }
  QuantisedSplats Quantised(const VqSettings& settings) const override {
    return QuantisedAvatar(model_, settings);
  }
  void WriteGlb(const std::string&, bool) const override {
    throw Error(folder_, "--glb", "is only for scenes; an avatar's run already has avatar.glb");
  }
  TestViews AsTrained() override { return ViewsOfAvatar(model_, flame_, video_, background_); }
  TestViews FromFile(const std::string& path) override {
    AvatarModel model = model_;
    ReadQuantisedAvatar(path, model);
    return ViewsOfAvatar(model, flame_, video_, background_);
  }

 private:
  std::string folder_;
  AvatarModel model_;
  FlameModel flame_;
  TrackedVideo video_;
  std::array<float, 3> background_;
};

// Trained with GaussianAvatars.
class BoundSplats : public ExportSubject {
 public:
  // flame: the avatar's.
  BoundSplats(const ExportSource& source, AvatarModel model, FlameModel flame)
      : ExportSubject(source.splats, RestPose(model)),
        source_(source),
        model_(std::move(model)),
        flame_(std::move(flame)) {}
  bool is_avatar() const override { return true; }
  QuantisedSplats Quantised(const VqSettings& settings) const override {
    return QuantisedAvatar(model_, settings);
  }
  void WriteGlb(const std::string& path, bool truncate_degree) const override {
    WriteAvatarGlb(path, model_, &flame_, {false, truncate_degree});
  }
  void WriteRun(const std::string& folder, bool truncate_degree) const override {
    if (source_.data.empty())
      throw Error("--run", "needs -s: the data set whose frames are rendered and measured");
    WriteImportedRun(folder, {source_.splats, source_.data, source_.flame}, model_);
    WriteGlb(folder + "/avatar.glb", truncate_degree);
  }
  TestViews AsTrained() override { return {}; }
  TestViews FromFile(const std::string&) override { return {}; }

 private:
  ExportSource source_;
  AvatarModel model_;
  FlameModel flame_;
};

std::unique_ptr<ExportSubject> LoadBound(const ExportSource& source) {
  if (source.flame.empty())
    throw Error(source.splats, "--flame", "is needed: the FLAME model that it was trained with");
  FlameModel flame = LoadFlameModel(source.flame);
  AvatarModel model = ReadGaussianAvatar(source.splats, flame, source.data);
  flame = FlameOf(model, std::move(flame));
  return std::make_unique<BoundSplats>(source, std::move(model), std::move(flame));
}

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
  if (source.views || source.measure)
    data = LoadSplitScene(Or(source.data, run["source"].String()), SplitFromJson(run));
  return std::make_unique<SceneSplats>(path, std::move(data), BackgroundOf(run));
}

}  // namespace

void ExportSubject::WriteRun(const std::string&, bool) const {
  throw Error(path_, "--run", "is for point clouds of GaussianAvatars");
}

std::unique_ptr<ExportSubject> LoadExportSubject(const ExportSource& source) {
  if (source.model.empty() && SplatLayoutOf(source.splats) == SplatLayout::kPly &&
      IsGaussianAvatarPly(source.splats))
    return LoadBound(source);
  if (source.model.empty())
    return std::make_unique<SceneSplats>(source.splats, SceneData(), std::array<float, 3>());
  std::unique_ptr<ExportSubject> subject = LoadRun(source);
  if (source.measure && subject->AsTrained().count == 0)
    throw Error(source.model, "--measure", "the run has no held-out views: train with --eval");
  return subject;
}

}  // namespace cosplat
