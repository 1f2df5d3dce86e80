#include "apps/study/runs/study_runner.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "apps/cosplat/run/run_folder.h"
#include "apps/study/bench/machine.h"
#include "apps/study/bench/measure.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/io/ply.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

constexpr double kMegabyte = 1e6;

// Generates the head, unless it already exists with these arguments. A folder of that name that was
// not generated here is left alone.
void MakeHead(const StudyData& data, const StudySettings& s, const StudyChildren& children) {
  const std::string folder = s.out + "/" + data.source, mark = folder + "/made_with.txt";
  const std::string with = ShellLine(*data.make_head);
  if (fs::exists(mark)) {
    const std::vector<char> before = ReadFile(mark);
    if (std::string(before.begin(), before.end()) == with) return;
  } else if (fs::exists(folder)) {
    throw Error(folder, "is there and no head that a study made: name the data differently");
  }
  fs::remove_all(folder);
  MakeDirectories(folder);
  WriteFileAtomically(mark, "unfinished\n");
  std::vector<std::string> film{"make-head", "-o", folder};
  film.insert(film.end(), data.make_head->begin(), data.make_head->end());
  children.Run(film);
  WriteFileAtomically(mark, with);
}

// False if files cannot represent the basis.
bool HasSplats(const std::string& model) { return fs::exists(model + "/point_cloud"); }

// Figures of one evaluation in results.json, and of what was saved at that step.
StudyFigures CheckpointOf(const std::string& model, int iteration, const JsonField& results) {
  StudyFigures figures;
  for (const auto& [key, value] : results.raw().items())
    if (key != "LPIPS") figures[key] = results[key].Number();  // LPIPS_<net> names the network
  figures["iterations"] = iteration;
  const std::string splats = SplatPath(model, iteration);
  if (!fs::exists(splats)) return figures;
  figures["gaussians"] = double(ReadPly(splats).size());
  figures["ply_mb"] = double(fs::file_size(splats)) / kMegabyte;
  return figures;
}

void AddNumbers(const std::string& path,
                const std::vector<const char*>& keys,
                StudyFigures& figures) {
  const Json json = ReadJson(path);
  for (const char* key : keys) figures[key] = JsonField(path, json)[key].Number();
}

// Cost of the finished model, and the quality of its files.
void AddCosts(const std::string& model, StudyFigures& figures) {
  AddNumbers(model + "/stats.json", {"gaussians", "seconds", "cpu_seconds", "peak_mb"}, figures);
  if (!HasSplats(model)) return;
  AddNumbers(model + "/export.json",
             {"ply_psnr", "ply_ssim", "vq_mb", "vq_psnr", "vq_ssim", "mean_degree"},
             figures);
  figures["fps"] = StudyFramesPerSecond(model);
}

// Trains and measures, each step as a user would.
void RunSteps(const StudyRun& run,
              const StudySettings& s,
              const StudyChildren& children,
              const std::string& model) {
  if (run.data.make_head) MakeHead(run.data, s, children);
  std::vector<std::string> train = run.TrainArguments(s.data + "/", s.out + "/", model);
  if (!isatty(STDERR_FILENO)) train.push_back("--quiet");  // a study's log has one line per run
  children.Run(train);
  if (!s.lpips.empty()) children.Run({"metrics", "-m", model, "--lpips", s.lpips});
  if (HasSplats(model))
    children.Run({"export", "-m", model, "--vq", model + "/quantised.zip", "--measure"});
}

void ReadResults(const std::string& model, StudyLine& line) {
  const std::string path = model + "/results.json";
  const Json json = ReadJson(path);
  const JsonField results(path, json);
  const std::string prefix = "ours_";
  for (const auto& [key, value] : json.items()) {
    if (key.rfind(prefix, 0) != 0) continue;
    const int iteration = std::atoi(key.c_str() + prefix.size());
    line.checkpoints.push_back(CheckpointOf(model, iteration, results[key]));
  }
  const auto earlier = [](const StudyFigures& a, const StudyFigures& b) {
    return a.at("iterations") < b.at("iterations");
  };
  std::sort(line.checkpoints.begin(), line.checkpoints.end(), earlier);
  if (line.checkpoints.empty()) throw Error(path, "has no figures: train with --eval");
  AddCosts(model, line.checkpoints.back());
}

}  // namespace

std::string StudyModelFolder(const StudyRun& run, const StudySettings& settings) {
  return settings.out + "/models/" + run.Id();
}

StudyLine MeasureStudyRun(const StudyRun& run,
                          const StudySettings& s,
                          const StudyChildren& children) {
  const auto start = std::chrono::steady_clock::now();
  const std::string model = StudyModelFolder(run, s);
  fs::remove_all(model);  // of an interrupted run
  RunSteps(run, s, children, model);
  StudyLine line;
  line.data = run.data.name;
  line.name = run.name;
  line.label = run.label;
  line.groups = run.groups;
  line.minus = run.minus;
  line.seed = run.seed;
  line.command = run.Command();
  line.version = COSPLAT_VERSION;
  line.cpu = CpuName();
  ReadResults(model, line);
  line.checkpoints.back()["run_seconds"] = SecondsSince(start);
  return line;
}

}  // namespace cosplat
