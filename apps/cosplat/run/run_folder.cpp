#include "apps/cosplat/run/run_folder.h"

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "splat/base/data_files.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/ply.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

// A Python string literal.
std::string Quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

// Formatted as Python prints it: 3DGS's tools evaluate this line.
std::string CfgArgs(const TrainOptions& o) {
  const auto flag = [](bool b) { return std::string(b ? "True" : "False"); };
  const bool white = o.background == Background::kWhite;
  return "Namespace(data_device='cpu', eval=" + flag(o.eval) +
         ", images='images', model_path=" + Quoted(fs::absolute(o.model).string()) +
         ", resolution=" + std::to_string(o.resolution) +
         ", sh_degree=" + std::to_string(o.sh_degree) +
         ", source_path=" + Quoted(fs::absolute(o.source).string()) +
         ", white_background=" + flag(white) + ")";
}

bool FilesHold(const JsonField& run) {
  const JsonField basis = run["basis"];
  return IsHarmonic(BasisFromString(basis.String(), run.file(), basis.path()),
                    run["degree"].Integer());
}

bool HasImages(const std::string& folder) {
  std::error_code missing;
  for (const auto& entry : fs::directory_iterator(folder, missing))
    if (IsImageName(entry.path().string())) return true;
  return false;
}

}  // namespace

void WriteRunConfiguration(const std::string& folder,
                           const TrainOptions& options,
                           const std::string& config_ini,
                           const Json& run) {
  MakeDirectories(folder);
  WriteFileAtomically(folder + "/cfg_args", CfgArgs(options));
  WriteFileAtomically(folder + "/config.ini", config_ini);
  WriteFileAtomically(folder + "/run.json", run.dump(2) + "\n");
}

bool IsInside(const std::string& path, const std::string& folder) {
  std::error_code missing;
  const fs::path inside =
      fs::weakly_canonical(path, missing).lexically_relative(fs::weakly_canonical(folder, missing));
  return !inside.empty() && *inside.begin() != "..";
}

void RefuseDataFolder(const std::string& option,
                      const std::string& folder,
                      const std::string& source,
                      const std::string& run) {
  if (!IsInside(folder, source)) return;
  std::error_code missing;
  const fs::path data = fs::weakly_canonical(source, missing);
  fs::path place = fs::weakly_canonical(folder, missing);
  const bool is_data = place == data;
  for (; place != data; place = place.parent_path())  // runs may lie in there
    if (IsRun(place.string())) return;
  const auto written = [&](const std::string& path) { return fs::last_write_time(path, missing); };
  if (fs::is_regular_file(folder, missing) && written(folder) <= written(run + "/run.json"))
    throw Error(option + " " + folder,
                "is a file of the data, which would be replaced: choose another name");
  if (is_data || HasImages(folder))
    throw Error(option + " " + folder,
                std::string(is_data ? "is the folder" : "is a folder of images") +
                    " of the data: results need one of their own");
}

void RefuseInput(const std::string& option, const std::string& output, const std::string& input) {
  std::error_code missing;
  if (fs::equivalent(output, input, missing))
    throw Error(option + " " + output,
                "is the input, which would be replaced: choose another name");
}

void RemoveRun(const std::string& folder) {
  if (!fs::exists(folder + "/run.json")) return;
  // run.json last, so that an interrupted removal is repeated.
  constexpr const char* kFiles[] = {"checkpoint.bin",
                                    "stats.json",
                                    "results.json",
                                    "per_view.json",
                                    "refined_track.json",
                                    "blendshapes.json",
                                    "skipped_frames.json",
                                    "export.json",
                                    "exposure.json",
                                    "avatar.glb",
                                    "blocks",
                                    "report.html",
                                    "orbit.mp4",
                                    "cfg_args",
                                    "run.json"};
  std::error_code code;
  const auto remove = [&](const fs::path& path) {
    if (!code) fs::remove_all(path, code);
    if (code) throw Error(path.string(), "cannot be removed: " + code.message());
  };
  // Images of other data, which may be in folders of these names, stay.
  for (const char* kind : {"point_cloud", "test", "train"}) {
    std::vector<fs::path> found;
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(folder + "/" + kind, missing)) {
      const std::string name = entry.path().filename().string();
      if (name.rfind("iteration_", 0) == 0 || name.rfind("ours_", 0) == 0)
        found.push_back(entry.path());
    }
    for (const fs::path& path : found) remove(path);
  }
  for (const char* file : kFiles) remove(folder + "/" + file);
}

bool IsRun(const std::string& folder) {
  return fs::exists(folder + "/run.json") || fs::exists(folder + "/cfg_args");
}

JsonField ReadRun(const std::string& folder) {
  const std::string own = folder + "/run.json", of_video = folder + "/avatar";
  if (!IsRun(folder))
    throw Error(own,
                IsRun(of_video) ? "is missing: the run of this video is " + of_video
                                : "is missing: there is no run");
  return {own, fs::exists(own) ? ReadJson(own) : RunOfCfgArgs(folder)};
}

bool HadSoundData(const std::string& folder) {
  const JsonField run = ReadRun(folder);
  return !run.Has("data_is_sound") || run["data_is_sound"].raw() != false;
}

Json CameraToJson(const Camera& c) {
  return {{"width", c.width},
          {"height", c.height},
          {"intrinsics", {c.fx, c.fy, c.cx, c.cy}},
          {"rotation", c.rotation},
          {"translation", c.translation}};
}

Camera CameraFromJson(const JsonField& json) {
  Camera c;
  c.width = json["width"].Integer();
  c.height = json["height"].Integer();
  const std::vector<float> k = json["intrinsics"].Numbers(4);
  c.fx = k[0], c.fy = k[1], c.cx = k[2], c.cy = k[3];
  const std::vector<float> r = json["rotation"].Numbers(9), t = json["translation"].Numbers(3);
  std::copy(r.begin(), r.end(), c.rotation.begin());
  std::copy(t.begin(), t.end(), c.translation.begin());
  return c;
}

std::string SplatPath(const std::string& folder, int iteration) {
  return folder + "/point_cloud/iteration_" + std::to_string(iteration) + "/point_cloud.ply";
}

bool CanSaveSplats(const TrainOptions& o) {
  if (IsHarmonic(o.basis, o.sh_degree)) return true;
  if (!o.quiet)
    std::printf("no splats will be saved: %s is not spherical harmonics, so no file can hold it\n",
                ToString(o.basis).c_str());
  return false;
}

void RequireSplats(const JsonField& run) {
  if (FilesHold(run)) return;
  throw Error(run.file(),
              "basis",
              "is " + run["basis"].String() +
                  ", which is not spherical harmonics: no splats of this run were saved");
}

void SaveSplats(const std::string& folder, int iteration, Gaussians gaussians) {
  ConvertBasis(gaussians, Basis::kSh);
  WritePly(MakeSplatPath(folder, iteration), gaussians);
}

std::string MakeSplatPath(const std::string& folder, int iteration) {
  const std::string path = SplatPath(folder, iteration);
  MakeDirectories(fs::path(path).parent_path().string());
  return path;
}

int IterationIn(const std::string& name) {
  const std::string prefix = "iteration_";
  return name.starts_with(prefix) ? std::atoi(name.c_str() + prefix.size()) : -1;
}

int LastIteration(const std::string& folder) {
  int last = -1;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder + "/point_cloud", ignored))
    last = std::max(last, IterationIn(entry.path().filename().string()));
  return last;
}

int SavedIteration(const std::string& folder, const JsonField& run) {
  const int last = run["iterations"].Integer();
  if (fs::exists(SplatPath(folder, last)) || !FilesHold(run)) return last;
  const int latest = LastIteration(folder);
  if (latest < 0)
    throw Error(folder, "point_cloud", "contains no iteration_N: not a trained model");
  return latest;
}

void WriteSkipped(const std::string& folder, const std::vector<SkippedFrame>& skipped) {
  Json list = Json::array();
  for (const SkippedFrame& frame : skipped)
    list.push_back({{"name", frame.name}, {"reason", frame.reason}});
  if (!skipped.empty()) WriteFileAtomically(folder + "/skipped_frames.json", list.dump(2) + "\n");
}

void WriteStatistics(const std::string& folder,
                     const TrainingStatistics& s,
                     size_t skipped_frames,
                     const Json& blocks) {
  Json phases = Json::object();
  for (size_t i = 0; i < kPhaseNames.size(); ++i)
    phases[kPhaseNames[i]] = s.steps ? 1e3 * s.times.seconds[i] / double(s.steps) : 0.0;
  Json json{{"iterations", s.iterations},
            {"seconds", s.seconds},
            {"cpu_seconds", s.cpu_seconds},
            {"gaussians", s.gaussians},
            {"degrees", s.degrees},
            {"mean_degree", s.bands.mean},
            {"rest_saved", s.bands.rest_saved},
            {"drop_psnr", s.drop_psnr},
            {"pruned", s.pruned},
            {"ms_per_step", s.ms_per_step},
            {"phases_ms", phases},
            {"peak_mb", PeakMegabytes()},
            {"skipped_frames", skipped_frames},
            {"ignored_gradients", s.ignored_gradients}};
  if (s.exchanged.steps > 0)
    json["batch"] = {{"ranks", s.exchanged.ranks},
                     {"steps", s.exchanged.steps},
                     {"views", s.exchanged.views},
                     {"groups_drawn", s.exchanged.groups_drawn},
                     {"groups_updated", s.exchanged.groups_updated},
                     {"numbers_assembled", s.exchanged.assembled},
                     {"numbers_handed_over", s.exchanged.handed_over},
                     {"bytes_sent", s.exchanged.bytes_sent},
                     {"exchange_seconds", s.exchanged.seconds}};
  if (!blocks.empty()) json["blocks"] = blocks;
  WriteFileAtomically(folder + "/stats.json", json.dump(2) + "\n");
}

// Read from /proc: getrusage's maximum starts at the memory of the process that started this one.
double PeakMegabytes() {
  std::ifstream status("/proc/self/status");
  const std::string key = "VmHWM:";  // followed by kB
  for (std::string line; std::getline(status, line);)
    if (line.rfind(key, 0) == 0) return std::atof(line.c_str() + key.size()) / 1024;
  return 0;
}

}  // namespace cosplat
