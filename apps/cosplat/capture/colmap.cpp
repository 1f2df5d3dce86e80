#include "apps/cosplat/capture/colmap.h"

#include <algorithm>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <memory>

#include "apps/cosplat/run/process.h"
#include "apps/cosplat/run/progress_bar.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/colmap_model.h"
#include "splat/io/dataset.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

// Up to here every pair is matched: 11,000 pairs, at 0.7 s of processor time each.
constexpr size_t kMaxExhaustive = 150;
// COLMAP's 3200 px and 8192 features take four times the time and memory on a CPU, for no better
// images at the size of training.
constexpr int kFeatureSize = 1600;  // px, longer side
constexpr int kMaxFeatures = 4096;  // per photograph
// From this many per lens on, four distortion coefficients and two focal lengths are found, else
// one of each: of fewer, taken at the same height with a level camera, COLMAP then registers only
// some.
constexpr size_t kMinForOpencvModel = 30;
// px at the features' size. Few photographs can be explained by a wrong focal length, a half of the
// true one or less; what gives that away is the error: 1.1 px in place of 0.2 for ten photographs
// of a room, in 14 of 120 runs, since COLMAP's matches differ from run to run. The nine that were
// looked at had begun with two photographs taken from very different directions, and were right
// from closer ones.
constexpr double kSuspiciousError = 0.7;
constexpr int kCloserPair = 8;      // degrees between the first two photographs; COLMAP's own: 16
constexpr int kMatchingBlock = 10;  // photographs; only how often progress is reported
constexpr size_t kTail = 5;         // lines shown of a command that failed

struct Progress {
  int done = 0, total = 0;  // total 0: one per photograph
};

// From a line of COLMAP's output, such as "Processed file [3/50]", "Matching block [1/5, 2/5] in
// 0.4s", "Registering image #12 (5)". Done is 0 where the line says nothing about progress.
Progress ParseProgress(const std::string& line) {
  int a = 0, n = 0, b = 0, m = 0;
  const size_t bracket = line.find('[');
  if (bracket != std::string::npos) {
    const char* text = line.c_str() + bracket;
    if (std::sscanf(text, "[%d/%d, %d/%d]", &a, &n, &b, &m) == 4) return {(a - 1) * m + b, n * m};
    if (std::sscanf(text, "[%d/%d]", &a, &n) == 2) return {a, n};
  }
  if (std::sscanf(line.c_str(), "Registering image #%d (%d)", &n, &a) == 2) return {a, 0};
  return {};
}

using Options = std::vector<std::pair<std::string, std::string>>;

class ColmapRunner {
 public:
  ColmapRunner(const ColmapSettings& settings, std::string log, int photographs)
      : settings_(settings), log_(std::move(log)), photographs_(photographs) {}

  // Returns the exit status (process.h).
  int TryRun(const std::string& title, const std::string& command, const Options& options) {
    std::vector<std::string> args{settings_.program, command};
    for (const auto& [name, value] : options) args.insert(args.end(), {name, value});
    std::ofstream log(log_, std::ios::app);
    log << "$";
    for (const std::string& arg : args) log << " " << arg;
    log << std::endl;
    if (!log) throw Error(log_, "cannot be written");
    tail_.clear();
    std::unique_ptr<ProgressBar> bar;
    // COLMAP is a Qt program, which would need a display.
    return RunProcess(args, {"QT_QPA_PLATFORM=offscreen"}, [&](const std::string& line) {
      log << line << std::endl;
      Remember(line);
      const Progress progress = ParseProgress(line);
      if (progress.done < 1) return;
      const int total = progress.total > 0 ? progress.total : photographs_;
      if (!bar)
        bar = std::make_unique<ProgressBar>(title, total, settings_.quiet, OffTerminal::kLines);
      bar->Update(std::min(progress.done, total), "");
    });
  }

  void Run(const std::string& title, const std::string& command, const Options& options) {
    const int status = TryRun(title, command, options);
    if (status != 0) Fail(command, status);
  }

  [[noreturn]] void Fail(const std::string& command, int status) const {
    for (const std::string& line : tail_) std::fprintf(stderr, "  %s\n", line.c_str());
    throw Error("colmap " + command, ExitText(status) + "; its log is " + log_);
  }

 private:
  void Remember(const std::string& line) {
    if (line.find_first_not_of(" =") == std::string::npos) return;  // empty, or a rule
    tail_.push_back(line);
    if (tail_.size() > kTail) tail_.pop_front();
  }

  const ColmapSettings& settings_;
  std::string log_;
  int photographs_;
  std::deque<std::string> tail_;
};

struct LargestModel {
  std::string folder;  // empty: there is none
  ColmapModel model;
};

LargestModel FindLargestModel(const std::string& sparse) {
  LargestModel largest;
  std::vector<std::string> folders;
  for (const auto& entry : fs::directory_iterator(sparse))
    if (entry.is_directory()) folders.push_back(entry.path().string());
  std::sort(folders.begin(), folders.end());
  for (const std::string& folder : folders) {
    ColmapModel model = ReadColmapModel(folder);
    if (largest.folder.empty() || model.images.size() > largest.model.images.size())
      largest = {folder, std::move(model)};
  }
  return largest;
}

Registration RegistrationOf(const ColmapModel& model, const std::vector<std::string>& names) {
  Registration result;
  for (const ColmapImage& image : model.images) result.registered.push_back(image.name);
  std::sort(result.registered.begin(), result.registered.end());
  std::set_difference(names.begin(),
                      names.end(),
                      result.registered.begin(),
                      result.registered.end(),
                      std::back_inserter(result.not_registered));
  result.points = model.points.size() / 3;
  result.mean_error = model.mean_error;
  return result;
}

// COLMAP's layout of undistorted images, without what belongs to its dense reconstruction, as 3DGS
// and other trainers read it.
void TidyDataset(const std::string& folder) {
  if (!fs::is_directory(folder + "/sparse"))
    throw Error("colmap image_undistorter", "wrote no model to " + folder);
  fs::rename(folder + "/sparse", folder + "/model");
  fs::create_directory(folder + "/sparse");
  fs::rename(folder + "/model", folder + "/sparse/0");
  for (const char* name : {"stereo", "run-colmap-geometric.sh", "run-colmap-photometric.sh"})
    fs::remove_all(folder + "/" + name);
}

void EmptyFolder(const std::string& folder) {
  fs::remove_all(folder);
  MakeDirectories(folder);
}

struct Files {
  std::string images, database, sparse, sparse_again, undistorted;
  explicit Files(const std::string& workspace)
      : images(workspace + "/photographs"),
        database(workspace + "/database.db"),
        sparse(workspace + "/sparse"),
        sparse_again(workspace + "/sparse_again"),
        undistorted(workspace + "/undistorted") {}
};

bool AreFew(const Photographs& photographs) {
  return photographs.names.size() < kMinForOpencvModel * size_t(photographs.lenses);
}

Options FeatureOptions(const Photographs& photographs,
                       const Files& files,
                       const ColmapSettings& settings) {
  const std::string each = photographs.lenses == 1 ? "" : "_per_folder";
  return {{"--database_path", files.database},
          {"--image_path", files.images},
          {"--ImageReader.camera_model", AreFew(photographs) ? "SIMPLE_RADIAL" : "OPENCV"},
          {"--ImageReader.single_camera" + each, "1"},
          {"--SiftExtraction.use_gpu", "0"},
          {"--SiftExtraction.num_threads", std::to_string(settings.threads)},
          {"--SiftExtraction.max_image_size", std::to_string(kFeatureSize)},
          {"--SiftExtraction.max_num_features", std::to_string(kMaxFeatures)}};
}

Options MatchOptions(const std::string& matching,
                     const Files& files,
                     const ColmapSettings& settings) {
  Options options{{"--database_path", files.database},
                  {"--SiftMatching.use_gpu", "0"},
                  {"--SiftMatching.num_threads", std::to_string(settings.threads)}};
  if (matching == "exhaustive")
    options.push_back({"--ExhaustiveMatching.block_size", std::to_string(kMatchingBlock)});
  return options;
}

Options UndistortOptions(const LargestModel& largest,
                         const Files& files,
                         const ColmapSettings& settings) {
  return {{"--image_path", files.images},
          {"--input_path", largest.folder},
          {"--output_path", files.undistorted},
          {"--output_type", "COLMAP"},
          {"--max_image_size", std::to_string(settings.max_size)}};
}

// Into the folder `sparse`; without a folder if there is no model.
LargestModel MapOnce(const Files& files,
                     const std::string& sparse,
                     const Options& more,
                     const ColmapSettings& settings,
                     ColmapRunner& colmap) {
  EmptyFolder(sparse);
  Options options{{"--database_path", files.database},
                  {"--image_path", files.images},
                  {"--output_path", sparse},
                  {"--Mapper.num_threads", std::to_string(settings.threads)}};
  options.insert(options.end(), more.begin(), more.end());
  const int status = colmap.TryRun("cameras", "mapper", options);
  LargestModel largest = FindLargestModel(sparse);
  // It exits with 1 if it finds no model, which says more about the photographs.
  if (status != 0 && (status != 1 || !largest.folder.empty())) colmap.Fail("mapper", status);
  return largest;
}

// px at the features' size; the stored one is of the photographs'.
double ErrorOf(const ColmapModel& model) {
  int size = kFeatureSize;
  for (const auto& [id, camera] : model.cameras)
    size = std::max({size, camera.lens.width, camera.lens.height});
  return model.mean_error * kFeatureSize / size;
}

LargestModel Map(const Photographs& photographs,
                 const Files& files,
                 const ColmapSettings& settings,
                 ColmapRunner& colmap) {
  LargestModel first = MapOnce(files, files.sparse, {}, settings, colmap);
  if (!AreFew(photographs) || ErrorOf(first.model) <= kSuspiciousError) return first;
  LargestModel again = MapOnce(files,
                               files.sparse_again,
                               {{"--Mapper.init_min_tri_angle", std::to_string(kCloserPair)}},
                               settings,
                               colmap);
  const size_t before = first.model.images.size(), now = again.model.images.size();
  const bool better =
      now > before || (now == before && again.model.mean_error < first.model.mean_error);
  return better ? again : first;
}

}  // namespace

std::string ResolveMatching(const std::string& matching, const Photographs& photographs) {
  if (matching != "auto") return matching;
  const bool many = photographs.names.size() > kMaxExhaustive;
  return photographs.is_video || many ? "sequential" : "exhaustive";
}

Registration FindCameras(const Photographs& photographs,
                         const ColmapSettings& settings,
                         const std::string& workspace,
                         const std::string& folder) {
  const Files files(workspace);
  ColmapRunner colmap(settings, workspace + "/log.txt", int(photographs.names.size()));
  colmap.Run("features", "feature_extractor", FeatureOptions(photographs, files, settings));
  const std::string matching = ResolveMatching(settings.matching, photographs);
  colmap.Run("matches", matching + "_matcher", MatchOptions(matching, files, settings));
  const LargestModel largest = Map(photographs, files, settings, colmap);
  const Registration result = RegistrationOf(largest.model, photographs.names);
  if (result.registered.size() < kMinPhotographs)
    throw Error(files.images,
                "COLMAP found the cameras of " + std::to_string(result.registered.size()) + " of " +
                    std::to_string(photographs.names.size()) +
                    " photographs: they overlap too little or show too little texture "
                    "(docs/scenes.md)");
  EmptyFolder(files.undistorted);
  colmap.Run("undistort", "image_undistorter", UndistortOptions(largest, files, settings));
  TidyDataset(files.undistorted);
  LoadScene(files.undistorted, {});  // throws Error if something is missing
  fs::remove_all(folder);
  fs::rename(files.undistorted, folder);
  return result;
}

}  // namespace cosplat
