// cosplat train-avatar: trains a head avatar from tracked video.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/avatar_options.h"
#include "apps/cosplat/options/command_line.h"
#include "apps/cosplat/run/avatar_blendshapes.h"
#include "apps/cosplat/run/head_model.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/test_images.h"
#include "apps/cosplat/run/train_run.h"
#include "avatar/io/avatar_file.h"
#include "avatar/model/corrections.h"
#include "avatar/train/avatar_subject.h"
#include "flame/eyelids.h"
#include "flame/model.h"
#include "flame/mouth.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/ply.h"
#include "splat/io/splat_file.h"

namespace cosplat {
namespace {

// The avatar as it is stored.
AvatarModel ModelOf(const AvatarOptions& o, const AvatarSubject& subject, const Trainer& trainer) {
  AvatarModel model = subject.Model(trainer.CaughtUp());
  model.background = o.EvaluationBackground();
  DropIdleCorrections(model);
  return model;
}

void Evaluate(const AvatarOptions& o,
              const FlameModel& flame,
              const AvatarSubject& subject,
              const std::vector<Image8>& truth,
              const Trainer& trainer) {
  AvatarTestImages renderer(ModelOf(o, subject, trainer), flame);
  TestImageWriter writer(o.model, "test", trainer.iteration(), o.EvaluationBackground());
  for (size_t i = 0; i < truth.size(); ++i)
    renderer.WriteTestImage(subject.video().test[i], truth[i], writer);
  writer.Finish();
}

DataSplit SplitOf(const AvatarOptions& o) {
  return {
      {o.resolution, o.eval, o.fold}, o.test_frames.value_or(-1), o.fold_by_turn, o.focal_scale};
}

// Of the parameters as the files have them and the head model, by which a finished run knows them.
uint32_t TrackChecksum(const FlameModel& flame, const TrackedVideo& video) {
  DataChecksums sums;
  AddText("the FLAME model", flame.sha256, sums);
  for (const auto* frames : {&video.train, &video.test}) AddTrack("frame", *frames, sums);
  AddText("shape", Json(video.shape).dump() + Json(video.static_offset).dump(), sums);
  AddText("all", Json(sums).dump(), sums);
  return sums.back().second;
}

void SaveInputs(const AvatarOptions& o,
                const TrackedVideo& video,
                uint32_t track,
                bool sound,
                const std::string& config) {
  const Json run{{"kind", "avatar"},
                 {"source", o.source},
                 {"flame", o.flame},
                 {"split", ToJson(SplitOf(o))},
                 {"test_views", video.test.size()},
                 {"track", track},
                 {"iterations", o.iterations},
                 {"preset", NameOf(o.preset)},
                 {"degree", o.sh_degree},
                 {"basis", ToString(o.basis)},
                 {"seed", o.seed},
                 {"background", o.EvaluationBackground()},
                 {"refine_track", o.avatar.refine_track},
                 {"reference", ReferenceView(video)},
                 {"data_is_sound", sound},
                 {"version", COSPLAT_VERSION}};
  WriteRunConfiguration(o.model, o, config, run);
  WriteCamerasJson(o.model + "/cameras.json", CamerasOf(video));
}

DataChecksums ChecksumsOf(const AvatarOptions& o,
                          const FlameModel& flame,
                          const AvatarSubject& subject,
                          const std::vector<Image8>& truth,
                          const Gaussians& first) {
  const TrackedVideo& video = subject.video();
  DataChecksums sums;
  AddFrames("training frame", NamesOf(video.train), &subject.frame(0), sums);
  AddTrack("the track of training frame", video.train, sums);
  AddImages("test frame", truth, sums);
  AddTrack("the track of test frame", video.test, sums);
  AddText("the subject's shape", Json(video.shape).dump() + Json(video.static_offset).dump(), sums);
  AddText("the FLAME model", flame.sha256, sums);
  AddGaussians("the initial Gaussians", first, sums);
  AddFiles("the network of --lpips", o.lpips, sums);
  AddFiles("the file of --landmarks", o.landmarks, sums);
  return sums;
}

// Writes the initial Gaussians at rest.
void SaveFirstPoints(const AvatarOptions& o, const AvatarModel& first) {
  const Gaussians rest = RestPose(first);
  const std::vector<float> points(rest.values[kPosition].begin(), rest.values[kPosition].end());
  WritePointsPly(o.model + "/input.ply", points, std::vector<uint8_t>(points.size(), 128));
}

// Loads the held-out images before training, so that a broken one is found early. Frames with an
// unusable image move from the test frames to the skipped ones.
std::vector<Image8> LoadTestImages(TrackedVideo& video) {
  std::vector<Image8> images;
  std::vector<std::string> problems;
  for (const TrackedFrame& frame : video.test)
    problems.push_back(Problem([&] { images.push_back(LoadTrackedImage(video, frame)); }));
  const auto name_of = [](const TrackedFrame& frame) { return frame.name; };
  video.test = KeepUsable(std::move(video.test), problems, name_of, video.skipped);
  return images;
}

// Writes the training frames' parameters as refined by --refine-track.
void SaveRefinedTrack(const AvatarOptions& o, const AvatarSubject& subject) {
  const std::vector<FlameParams> track = subject.RefinedTrack();
  Json frames = Json::array();
  for (size_t i = 0; i < track.size(); ++i)
    frames.push_back({{"name", subject.video().train[i].name},
                      {"expression", track[i].expression},
                      {"pose", track[i].pose},
                      {"translation", track[i].translation}});
  WriteFileAtomically(o.model + "/refined_track.json", Json{{"frames", frames}}.dump() + "\n");
}

void Save(const AvatarOptions& o,
          const FlameModel& flame,
          const AvatarSubject& subject,
          const Trainer& trainer,
          AvatarBlendshapes& blendshapes) {
  AvatarModel model = ModelOf(o, subject, trainer);
  blendshapes.Fit(model);
  // The rest pose, for tools that know only 3DGS's layout.
  SaveSplats(o.model, trainer.iteration(), RestPose(model));
  AvatarFileOptions file;
  file.embed_flame = o.embed_flame;
  file.truncate_degree = o.truncate_degree;
  WriteAvatarGlb(o.model + "/avatar.glb", model, &flame, file);
}

}  // namespace

bool TrainAvatar(AvatarOptions o, const std::string& config) {
  RefuseDataFolder("-m", o.model, o.source);
  const RunStart how = ChooseStart(o, config);
  const auto load_model = [&] {
    o.flame = HeadModelOfTrack(o.flame, o.source);
    FlameModel flame = LoadFlameModel(o.flame);
    return o.mouth ? WithMouth(std::move(flame)) : flame;
  };
  if (how == RunStart::kFinished) {
    const FlameModel flame = load_model();
    const TrackedVideo video = LoadSplitVideo(o.source, SplitOf(o), flame);
    RequireDataOfRun(o.model, o.source, CamerasOf(video), video.test.size(), true);
    const JsonField run = ReadRun(o.model);
    if (run.Has("track") && run["track"].Number() != TrackChecksum(flame, video))
      throw Error(o.model,
                  "holds a finished run on another track or head model: --overwrite replaces it");
    PrintFinished(o);
    return HadSoundData(o.model);
  }
  const Device device = o.ResolveDevice();
  const std::shared_ptr<Lpips> lpips = LoadLpips(o);
  if (o.sh_degree > kMaxSplatFileDegree && !o.truncate_degree)
    throw Error("--sh_degree " + std::to_string(o.sh_degree),
                "exceeds standard glTF's degree 3: pass --truncate-degree to omit band 4 from what "
                "other programs read");
  o.ResolveBackground(Background::kRandom);
  FlameModel flame = load_model();
  TrackedVideo loaded = LoadSplitVideo(o.source, SplitOf(o), flame);
  const uint32_t track = TrackChecksum(flame, loaded);
  const bool sound = PrintFindings(o.source, CheckTrack(flame, loaded), o.strict, o.quiet);
  if (TracksEyelids(loaded)) {
    flame = WithEyelids(std::move(flame));
    EyelidsToExpression(flame, loaded);
  }
  const std::vector<Image8> truth = LoadTestImages(loaded);
  o.avatar.initial_gaussians = std::min(o.avatar.initial_gaussians, o.max_gaussians);
  AvatarSubject subject(flame, std::move(loaded), o.avatar);
  const TrackedVideo& video = subject.video();
  AvatarBlendshapes blendshapes(o.landmarks, flame, subject);
  TrainSettings settings = o.ToSettings(subject.extent());
  settings.crop_loss.distance = lpips;
  Trainer trainer(settings,
                  subject,
                  subject.InitialGaussians(o.sh_degree, o.basis, o.seed),
                  AvatarEngineOn(device, o.deterministic));
  RunCheckpoint checkpoint(
      o, config, how, ChecksumsOf(o, flame, subject, truth, trainer.state().gaussians));
  if (how == RunStart::kNew) RemoveRun(o.model);
  SaveInputs(o, video, track, sound, config);
  PrintSettled(o);
  if (!o.quiet) PrintSkipped(video.skipped);
  if (!o.quiet && o.OmitsLpips())
    std::printf("--preset %s: without its LPIPS loss, for which there is no network (--lpips)\n",
                NameOf(o.preset).c_str());
  SaveFirstPoints(o, subject.Model(trainer.state().gaussians));
  if (!o.quiet)
    std::printf("%s: %zu training and %zu test frames of %dx%d%s%s%s, on %s\n",
                video.layout.c_str(),
                video.train.size(),
                video.test.size(),
                video.train[0].camera.width,
                video.train[0].camera.height,
                flame.mouth.count() > 0 ? ", with a mouth" : "",
                flame.has_eyelids ? ", with eyelids" : "",
                subject.has_bust() ? ", with a bust" : "",
                NameOf(device).c_str());
  if (!o.quiet && subject.virtual_view_count() > 0)
    std::printf("%zu more views, made by the mesh, show what no camera did\n",
                subject.virtual_view_count());
  if (!o.quiet && !subject.IsMasked())
    std::printf(
        "the frames have no masks: the background becomes part of the avatar, and how it "
        "looks from where no camera was stays open\n");
  if (!o.quiet)
    std::printf("%s%s",
                UnitLine("FLAME model " + flame.name, flame.unit).c_str(),
                UnitLine("track " + video.source, video.unit).c_str());
  RunHooks hooks;
  hooks.lpips = lpips.get();
  hooks.save = [&, saves = CanSaveSplats(o)] {
    if (saves) Save(o, flame, subject, trainer, blendshapes);
    if (o.avatar.refine_track) SaveRefinedTrack(o, subject);
  };
  if (!truth.empty()) hooks.evaluate = [&] { Evaluate(o, flame, subject, truth, trainer); };
  RunTraining(o, trainer, video.skipped, hooks, checkpoint);
  blendshapes.Write(o.model);
  checkpoint.Remove();
  if (!o.quiet) std::printf("%s", blendshapes.Summary().c_str());
  return sound;
}

void AddTrainAvatar(CLI::App& app) {
  CLI::App* command = app.add_subcommand("train-avatar", "train a head avatar from tracked video");
  const auto o = std::make_shared<AvatarOptions>();
  o->Declare(*command);
  command->callback([o, command, &app] {
    o->Settle(*command);
    if (!TrainAvatar(*o, ConfigOf(app, *command))) EndAsWrong(o->source);
  });
}

}  // namespace cosplat
