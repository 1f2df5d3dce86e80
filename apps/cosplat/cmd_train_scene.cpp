// cosplat train-scene: trains a static scene from images, alone or as one of mpirun's ranks.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/command_line.h"
#include "apps/cosplat/options/scene_options.h"
#include "apps/cosplat/run/block_files.h"
#include "apps/cosplat/run/block_training.h"
#include "apps/cosplat/run/memory_plan.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/scene_start.h"
#include "apps/cosplat/run/stop_signals.h"
#include "apps/cosplat/run/test_images.h"
#include "apps/cosplat/run/train_run.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"
#include "splat/io/cameras_json.h"
#include "splat/io/ply.h"
#include "splat/io/scene_check.h"
#include "splat/train/ranks/ranks.h"
#include "splat/train/subject/scene_subject.h"
#include "splat/train/trainer.h"

namespace cosplat {
namespace {

void Evaluate(const SceneTrainOptions& o,
              Device device,
              const std::vector<TrainFrame>& test,
              int iteration,
              int degree,
              const Gaussians& g) {
  const auto rasterizer = MakeRasterizer(device);
  const auto tape = rasterizer->MakeTape();
  const RenderSettings render{o.EvaluationBackground(), degree};
  TestImageWriter writer(o.model, "test", iteration, render.background);
  RenderedImage image;
  FrameReader reader;
  for (size_t i = 0; i < test.size(); ++i) {
    const TrainFrame& frame = reader.At(test[i]);
    if (i + 1 < test.size()) reader.Expect(test[i + 1]);
    rasterizer->Forward(ViewOf(g), g.basis, frame.camera, render, image, *tape);
    writer.Write(image, frame.target, {}, frame.ignored);
  }
  writer.Finish();
}

// By the photographs' names, [3, 4] each, as 3DGS's code writes them.
void WriteExposures(const std::string& folder,
                    const std::vector<SceneView>& views,
                    const ExposureState& exposures) {
  Json json = Json::object();
  const float* number = exposures.value.data();
  for (const SceneView& view : views)
    for (int row = 0; row < 3; ++row, number += 4)
      json[view.name].push_back({number[0], number[1], number[2], number[3]});
  WriteFileAtomically(folder + "/exposure.json", json.dump() + "\n");
}

DataChecksums ChecksumsOf(const SceneTrainOptions& o,
                          const SceneData& scene,
                          const SceneSubject& subject,
                          const std::vector<TrainFrame>& test,
                          const Gaussians& first) {
  DataChecksums sums;
  AddFrames("training view", NamesOf(scene.train), subject.frames().data(), sums);
  AddFrames("test view", NamesOf(scene.test), test.data(), sums);
  AddGaussians("the initial points", first, sums);
  AddFiles("the network of --lpips", o.lpips, sums);
  return sums;
}

void SaveInputs(const SceneTrainOptions& o,
                const DataSplit& split,
                const SceneData& scene,
                bool sound,
                const std::string& config) {
  const Json run{{"kind", "scene"},
                 {"source", o.source},
                 {"split", ToJson(split)},
                 {"test_views", scene.test.size()},
                 {"iterations", o.iterations},
                 {"degree", o.sh_degree},
                 {"basis", ToString(o.basis)},
                 {"seed", o.seed},
                 {"device", NameOf(o.ResolveDevice())},
                 {"background", o.EvaluationBackground()},
                 {"data_is_sound", sound},
                 {"version", COSPLAT_VERSION}};
  WriteRunConfiguration(o.model, o, config, run);
  WriteCamerasJson(o.model + "/cameras.json", CamerasOf(scene));
  WritePointsPly(o.model + "/input.ply", scene.points, scene.point_colors, scene.origin);
}

}  // namespace

bool TrainScene(SceneTrainOptions o, const std::string& config, std::shared_ptr<Ranks> ranks) {
  if (FindPruneRule(o.prune).group_floor > 0)
    throw Error("--prune " + o.prune, "needs triangles: available in train-avatar only");
  if (o.blocks > 1 && !o.device) o.device = Device::kCpu;
  o.CheckBlocks();
  if (o.blocks > 1 && ranks->size() > o.blocks * size_t(o.batch))
    throw Error("--blocks " + std::to_string(o.blocks) + " --batch " + std::to_string(o.batch),
                "is trained by at most " + std::to_string(o.blocks * size_t(o.batch)) +
                    " ranks, these are " + std::to_string(ranks->size()));
  const bool writes = ranks->rank() == 0;
  if (!writes) o.quiet = true;
  RefuseDataFolder("-m", o.model, o.source);
  const RunStart how = ChooseStart(o, config, *ranks);
  if (how == RunStart::kFinished) {
    const std::string problem = writes ? Problem([&] {
      const SceneData scene = LoadSplitScene(o.source, SplitFromJson(ReadRun(o.model)));
      RequireDataOfRun(o.model, o.source, CamerasOf(scene), scene.test.size(), true);
    })
                                       : "";
    if (const std::string of_all = TextOfRankZero(problem, *ranks); !of_all.empty())
      throw Error(of_all, "");
    if (writes && o.blocks > 1) BlockFiles::Remove(o.model);  // it may have been stopped before
    PrintFinished(o);
    return Smallest(uint32_t(!writes || HadSoundData(o.model)), *ranks) != 0;
  }
  // "auto" is the CPU for all ranks if it is for one of them.
  const Device device = Device(Smallest(uint32_t(o.ResolveDevice()), *ranks));
  if (device == Device::kCpu) o.device = Device::kCpu;
  const std::shared_ptr<Lpips> lpips = LoadLpips(o);
  DataSplit split{{o.resolution, o.eval, o.fold}};
  ChooseImages(o.images, split);
  SceneData scene = LoadSplitScene(o.source, split);
  split.origin = scene.origin;
  bool sound = true;
  if (writes || o.strict) sound = PrintFindings(o.source, CheckScene(scene), o.strict, o.quiet);
  sound = Smallest(uint32_t(sound), *ranks) != 0;
  const MemoryPlan plan = PlanMemory(o, scene);
  o.max_gaussians = plan.at_once();
  TrainingScene loaded = LoadTrainingScene(scene, plan.for_photographs());
  SceneStart start = StartScene(o.random_points, o, loaded);
  start.settings.crop_loss.distance = lpips;
  start.first.origin = scene.origin;
  const std::vector<TrainFrame> test = std::move(loaded.test);
  SceneSubject subject(std::move(loaded.train), loaded.extent);
  subject.LimitReduced(plan.for_reduced());
  RunCheckpoint checkpoint(o, config, how, ChecksumsOf(o, scene, subject, test, start.first));
  // Made before anything is written, since it refuses what does not fit.
  std::unique_ptr<Trainer> whole;
  if (o.blocks == 1)
    whole =
        std::make_unique<Trainer>(start.settings,
                                  subject,
                                  std::move(start.first),
                                  StepEngineOn(device, o.deterministic, InstanceForecast(), ranks));
  scene.points = std::move(loaded.points);  // the initial points of the run
  scene.point_colors = std::move(loaded.point_colors);
  if (writes && how == RunStart::kNew) RemoveRun(o.model);
  if (writes) SaveInputs(o, split, scene, sound, config);
  PrintSettled(o);
  if (!o.quiet) PrintSkipped(scene.skipped);
  if (!o.quiet)
    std::printf("%s: %zu training and %zu test views of %dx%d, %s points, on %s\n",
                scene.layout.c_str(),
                scene.train.size(),
                scene.test.size(),
                subject.camera(0).width,
                subject.camera(0).height,
                WithThousands(scene.points.size() / 3).c_str(),
                NameOf(device).c_str());
  if (!o.quiet && o.eval && scene.test.empty())
    std::printf("--eval: the data has no test views, so there will be no figures\n");
  if (!o.quiet) std::printf("%s", PlaceLines(scene).c_str());
  const auto masked = std::count_if(scene.train.begin(), scene.train.end(), [](const SceneView& v) {
    return !v.mask_path.empty();
  });
  if (!o.quiet && masked > 0) std::printf("%zu views with masks\n", size_t(masked));
  if (!o.quiet) std::printf("%s\n", ToString(plan).c_str());
  if (!o.quiet && ranks->size() > 1) std::printf("%zu ranks\n", ranks->size());
  if (o.blocks > 1) {
    BlockHooks hooks;
    hooks.lpips = lpips.get();
    hooks.save_exposures = [&](const ExposureState& exposures) {
      WriteExposures(o.model, scene.train, exposures);
    };
    if (!test.empty())
      hooks.evaluate = [&](const Gaussians& gaussians) {
        Evaluate(o, device, test, o.iterations, gaussians.degree, gaussians);
      };
    TrainInBlocks(o, std::move(start), subject, scene.skipped, hooks, checkpoint, *ranks);
    if (!writes) return sound;
    checkpoint.Remove();
    BlockFiles::Remove(o.model);
    return sound;
  }
  Trainer& trainer = *whole;
  RunHooks hooks;
  hooks.ranks = ranks;
  hooks.lpips = lpips.get();
  hooks.save = [&, saves = CanSaveSplats(o)] {
    Gaussians gaussians = trainer.CaughtUp();
    gaussians.origin = scene.origin;
    if (writes && saves) SaveSplats(o.model, trainer.iteration(), std::move(gaussians));
    if (writes && o.exposure) WriteExposures(o.model, scene.train, trainer.state().exposures);
  };
  if (!test.empty())
    hooks.evaluate = [&] {
      const Gaussians gaussians = trainer.CaughtUp();
      if (writes)
        Evaluate(o, device, test, trainer.iteration(), trainer.active_degree(), gaussians);
    };
  RunTraining(o, trainer, scene.skipped, hooks, checkpoint);
  if (writes) checkpoint.Remove();
  return sound;
}

namespace {

// What ends all ranks alike rank 0 says; what ends one alone, that one.
void TrainOnRanks(const SceneTrainOptions& o, const std::string& config) {
  const std::shared_ptr<Ranks> ranks = JoinRanks();
  try {
    if (TrainScene(o, config, ranks)) return;
    ranks->EndTogether();
    if (ranks->rank() == 0) EndAsWrong(o.source);
    throw CLI::RuntimeError(kSomethingWrong);
  } catch (const Stopped& stopped) {
    ranks->EndTogether();
    if (ranks->rank() == 0) throw;
    throw CLI::RuntimeError(128 + stopped.signal);
  } catch (const Error& error) {
    if (ranks->size() == 1) throw;
    if (!ranks->EndTogether()) throw Error("rank " + std::to_string(ranks->rank()), error.what());
    if (ranks->rank() == 0) throw;
    throw CLI::RuntimeError(2);  // as main's
  }
}

}  // namespace

void AddTrainScene(CLI::App& app) {
  CLI::App* command = app.add_subcommand("train-scene", "train a static scene from photographs");
  const auto options = std::make_shared<SceneTrainOptions>();
  options->DeclareFolders(*command);
  command->add_option("-i,--images",
                      options->images,
                      "folder of the images, as 3DGS has it: images_4 divides their size by 4");
  options->DeclareTraining(*command);
  command->callback([options, command, &app] {
    options->Settle(*command);
    TrainOnRanks(*options, ConfigOf(app, *command));
  });
}

}  // namespace cosplat
