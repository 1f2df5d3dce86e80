// cosplat scene: from photographs or a video to a trained scene, with its report and an orbit.
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/capture/colmap.h"
#include "apps/cosplat/commands.h"
#include "apps/cosplat/options/command_line.h"
#include "apps/cosplat/options/scene_options.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/run_checkpoint.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/train_run.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/process.h"
#include "splat/base/text.h"
#include "splat/train/ranks/ranks.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// Steps of 3DGS's shorter evaluation: hours less than its 30,000 on a CPU.
constexpr int kIterations = 7000;
// Below this share the scene has holes that nobody expects.
constexpr double kFewRegistered = 0.6;

struct SceneCommand : SceneTrainOptions {
  std::string photographs, colmap = "colmap", matching = "auto";
  std::vector<std::string> features;  // "NAME=VALUE"
  int frames = 100, max_size = 1600;
  bool cameras_only = false;

  // Subfolders of the folder of results, which TrainOptions calls `model`.
  std::string Workspace() const { return model + "/colmap"; }
  std::string Data() const { return model + "/data"; }
};

// What the photographs were gathered from, and what the data set was made from.
Json InputOf(const SceneCommand& o) {
  Json input{{"files", IdentityOf(o.photographs)}};
  if (!fs::is_directory(o.photographs)) input["frames"] = o.frames;
  if (!o.features.empty()) input["features"] = o.features;  // else COLMAP keeps those it found
  return input;
}
Json DataInputOf(const SceneCommand& o, Json input) {
  input["max_size"] = o.max_size;
  input["matching"] = o.matching;
  return input;
}

// Whether the file is there and its "input" is this one.
bool IsOf(const std::string& file, const Json& input) {
  if (!fs::exists(file)) return false;
  const Json json = ReadJson(file);
  return json.value("input", Json()) == input;
}

// Gathers the photographs, unless they are there from an interrupted run on the same ones. Any
// other run's workspace is removed.
Photographs Gather(const SceneCommand& o, const Json& input) {
  const std::string file = o.Workspace() + "/photographs.json";
  if (!IsOf(file, input)) {
    fs::remove_all(o.Workspace());
    Json json =
        ToJson(GatherPhotographs(o.photographs, o.frames, o.Workspace() + "/photographs", o.quiet));
    json["input"] = input;
    WriteFileAtomically(file, json.dump(2) + "\n");
  }
  return PhotographsFromJson(JsonField(file, ReadJson(file)));
}

ColmapProgram ProgramOf(const SceneCommand& o) {
  const std::string program = FindProgram(o.colmap);
  if (program.empty())
    throw Error("--colmap " + o.colmap,
                "is not installed: on Debian and Ubuntu `apt-get install colmap` does so, or give "
                "its path");
  return ColmapProgram(program);
}

// "FeatureExtraction.type=ALIKED_N16ROT", with or without dashes.
std::vector<std::pair<std::string, std::string>> FeaturesOf(const SceneCommand& o) {
  std::vector<std::pair<std::string, std::string>> features;
  for (const std::string& text : o.features) {
    const size_t name = text.find_first_not_of('-'), equals = text.find('=');
    if (equals == std::string::npos || name >= equals)
      throw Error("--colmap-features " + text, "is not NAME=VALUE");
    features.emplace_back("--" + text.substr(name, equals - name), text.substr(equals + 1));
  }
  return features;
}

void Announce(const SceneCommand& o, const Photographs& photographs) {
  if (o.quiet) return;
  std::printf("%zu %s of %dx%d, %s; %s\n",
              photographs.names.size(),
              photographs.is_video ? "frames" : "photographs",
              photographs.width,
              photographs.height,
              photographs.lenses == 1 ? "taken with one lens"
                                      : (std::to_string(photographs.lenses) + " lenses").c_str(),
              ResolveMatching(o.matching, photographs) == "exhaustive"
                  ? "every pair is matched"
                  : "each is matched with those that follow it by name");
  PrintSkipped(photographs.skipped);
  if (std::max(photographs.width, photographs.height) > o.max_size)
    std::printf("images for training have at most %d px (--max-size)\n", o.max_size);
  std::fflush(stdout);
}

void PrintRegistration(const JsonField& json, const std::string& note) {
  const size_t registered = json["registered"].size(), missing = json["not_registered"].size();
  const size_t total = registered + missing;
  const double error = json.NumberOr("mean_error", 0);
  const std::string error_text = error > 0 ? Format(" with an error of {:.2f} px", error) : "";
  std::printf("cameras of %zu of %zu photographs, %s points%s%s\n",
              registered,
              total,
              WithThousands(size_t(json["points"].Number())).c_str(),
              error_text.c_str(),
              note.c_str());
  std::string names;
  for (size_t i = 0; i < missing; ++i) names += " " + json["not_registered"][i].String();
  if (missing > 0) std::printf("not registered:%s\n", names.c_str());
  if (double(registered) < kFewRegistered * double(total))
    std::fprintf(stderr,
                 "cosplat: warning: %zu of %zu photographs have no camera, so parts of the scene "
                 "are missing (docs/scenes.md)\n",
                 missing,
                 total);
  std::fflush(stdout);
}

void WriteRegistration(const std::string& file,
                       const Json& input,
                       const Photographs& photographs,
                       const Registration& found) {
  Json skipped = Json::array();
  for (const SkippedFrame& frame : photographs.skipped)
    skipped.push_back({{"name", frame.name}, {"reason", frame.reason}});
  const Json json{{"input", input},
                  {"registered", found.registered},
                  {"not_registered", found.not_registered},
                  {"skipped", skipped},
                  {"points", found.points},
                  {"mean_error", found.mean_error}};
  WriteFileAtomically(file, json.dump(2) + "\n");
}

// The data set with its cameras: that of an earlier run on the same photographs, or made now.
void MakeDataset(const SceneCommand& o) {
  const std::string file = o.model + "/registration.json";
  const Json input = InputOf(o), data_input = DataInputOf(o, input);
  const bool kept = fs::is_directory(o.Data()) && IsOf(file, data_input);
  std::string note = " (kept from an earlier run)";
  if (!kept) {
    if (!o.overwrite) RequireNoRun(o.model);  // it would be on other data
    ColmapProgram program = ProgramOf(o);
    const auto features = FeaturesOf(o);
    const auto start = std::chrono::steady_clock::now();
    const Photographs photographs = Gather(o, input);
    Announce(o, photographs);
    const int threads =
        int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
    RemoveFile(file);
    const Registration found = FindCameras(photographs,
                                           program,
                                           {o.matching, o.max_size, threads, o.quiet, features},
                                           o.Workspace(),
                                           o.Data());
    RemoveRun(o.model);
    WriteRegistration(file, data_input, photographs, found);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    note = " in " + std::to_string(int(taken.count())) + " s";
  }
  if (!o.quiet) PrintRegistration(JsonField(file, ReadJson(file)), note);
}

// Trains, unless an earlier run did so, and writes the report and the orbit. What was interrupted
// goes on. Returns as TrainScene.
bool Train(SceneCommand o, const std::string& config) {
  const std::string orbit = o.model + "/orbit.mp4";
  o.source = o.Data();
  o.resume = !o.overwrite;
  const bool sound = TrainScene(o, config, OneRank());
  if (o.eval) WriteReport(o.model, o.quiet);
  if (!fs::exists(orbit)) RenderVideo(o.model, VideoOf::kOrbit, "", orbit, o.device, o.quiet);
  return sound;
}

void Scene(const SceneCommand& o, const std::string& config) {
  std::error_code ignored;
  if (fs::equivalent(o.photographs, o.model, ignored))
    throw Error(o.model, "is the folder of the photographs: results need one of their own");
  MakeDataset(o);
  if (!o.cameras_only && !Train(o, config)) EndAsWrong(o.Data());
  if (o.cameras_only && !o.quiet) std::printf("data set: %s\n", o.Data().c_str());
}

}  // namespace

void AddScene(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("scene", "from photographs or a video to a scene; needs COLMAP");
  const auto o = std::make_shared<SceneCommand>();
  o->iterations = kIterations;
  o->eval = true;
  BeginGroup(*command, "Photographs");
  command->add_option("photographs", o->photographs, "a folder of photographs, or a video")
      ->required();
  command->add_option("-o,--out", o->model, "where results go")->required();
  command->add_option("--frames", o->frames, "of a video: how many to use, the sharpest ones")
      ->check(CLI::Range(int(kMinPhotographs), 10000));
  command->add_option("--max-size", o->max_size, "longer side of the images to train on, in pixels")
      ->check(CLI::Range(64, 16384));
  command
      ->add_flag("--cameras-only", o->cameras_only, "stop at the data set that train-scene reads")
      ->configurable(false);
  BeginGroup(*command, "More: COLMAP");
  command
      ->add_option(
          "--matching",
          o->matching,
          "which photographs are compared: exhaustive, all with all; sequential, each with "
          "those that follow it by name; auto: sequential for videos and from 151 on")
      ->check(CLI::IsMember({"auto", "exhaustive", "sequential"}));
  command->add_option("--colmap", o->colmap, "COLMAP's program, a name or a path")
      ->configurable(false);
  command
      ->add_option("--colmap-features",
                   o->features,
                   "NAME=VALUE of COLMAP's options for features and matches, passed on as it is, "
                   "such as FeatureExtraction.type=ALIKED_N16ROT; may be repeated")
      ->allow_extra_args(false)
      ->default_str("");
  o->DeclareTraining(*command);
  command->get_option("--eval")->default_str("true");  // config.ini has "false" for a flag else
  command->callback([=, &app] {
    std::erase(o->features, "");  // config.ini has "" for an option that is left out
    o->Settle(*command);
    Scene(*o, ConfigOf(app, *command));
  });
}

}  // namespace cosplat
