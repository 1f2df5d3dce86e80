#include "apps/cosplat/capture/colmap.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

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

// The settings' own options for features and matches that this command takes: each goes to every
// command that does, in place of ours.
ColmapOptions WithFeatures(ColmapOptions options,
                           const std::string& command,
                           const ColmapSettings& settings,
                           ColmapProgram& program) {
  for (const auto& [name, value] : settings.features) {
    if (!program.Takes(command, name)) continue;
    std::erase_if(options, [&](const ColmapOption& ours) {
      return std::find(ours.names.begin(), ours.names.end(), name) != ours.names.end();
    });
    options.push_back({{name}, value});
  }
  return options;
}

ColmapOptions FeatureOptions(const Photographs& photographs,
                             const Files& files,
                             const ColmapSettings& settings) {
  const std::string each = photographs.lenses == 1 ? "" : "_per_folder";
  return {{{"--database_path"}, files.database},
          {{"--image_path"}, files.images},
          {{"--ImageReader.camera_model"}, AreFew(photographs) ? "SIMPLE_RADIAL" : "OPENCV"},
          {{"--ImageReader.single_camera" + each}, "1"},
          {{"--FeatureExtraction.use_gpu", "--SiftExtraction.use_gpu"}, "0", false},
          {{"--FeatureExtraction.num_threads", "--SiftExtraction.num_threads"},
           std::to_string(settings.threads),
           false},
          {{"--FeatureExtraction.max_image_size", "--SiftExtraction.max_image_size"},
           std::to_string(kFeatureSize),
           false},
          {{"--SiftExtraction.max_num_features"}, std::to_string(kMaxFeatures), false}};
}

ColmapOptions MatchOptions(const Files& files, const ColmapSettings& settings) {
  return {{{"--database_path"}, files.database},
          {{"--FeatureMatching.use_gpu", "--SiftMatching.use_gpu"}, "0", false},
          {{"--FeatureMatching.num_threads", "--SiftMatching.num_threads"},
           std::to_string(settings.threads),
           false},
          {{"--ExhaustiveMatching.block_size"}, std::to_string(kMatchingBlock), false}};
}

ColmapOptions UndistortOptions(const LargestModel& largest,
                               const Files& files,
                               const ColmapSettings& settings) {
  return {{{"--image_path"}, files.images},
          {{"--input_path"}, largest.folder},
          {{"--output_path"}, files.undistorted},
          {{"--output_type"}, "COLMAP"},
          {{"--max_image_size"}, std::to_string(settings.max_size)}};
}

// Into the folder `sparse`; without a folder if there is no model. By the incremental mapper, also
// where the program has a global one, which is worse without known focal lengths (docs/scenes.md).
LargestModel MapOnce(const Files& files,
                     const std::string& sparse,
                     const ColmapOptions& more,
                     const ColmapSettings& settings,
                     ColmapRunner& colmap) {
  EmptyFolder(sparse);
  ColmapOptions options{{{"--database_path"}, files.database},
                        {{"--image_path"}, files.images},
                        {{"--output_path"}, sparse},
                        {{"--Mapper.num_threads"}, std::to_string(settings.threads), false}};
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
                               {{{"--Mapper.init_min_tri_angle"}, std::to_string(kCloserPair)}},
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
                         ColmapProgram& program,
                         const ColmapSettings& settings,
                         const std::string& workspace,
                         const std::string& folder) {
  const Files files(workspace);
  const std::string matcher = ResolveMatching(settings.matching, photographs) + "_matcher";
  for (const auto& [name, value] : settings.features)
    if (!program.Takes("feature_extractor", name) && !program.Takes(matcher, name))
      throw Error("--colmap-features " + name,
                  "is taken by neither `colmap feature_extractor` nor `colmap " + matcher + "`");
  ColmapRunner colmap(
      program, workspace + "/log.txt", int(photographs.names.size()), settings.quiet);
  const auto with_features = [&](const ColmapOptions& options, const std::string& command) {
    return WithFeatures(options, command, settings, program);
  };
  colmap.Run("features",
             "feature_extractor",
             with_features(FeatureOptions(photographs, files, settings), "feature_extractor"));
  ColmapOptions matching = MatchOptions(files, settings);
  colmap.Run("matches", matcher, with_features(matching, matcher));
  // By default COLMAP up to 3.10 matches the ten next photographs and those at distances of powers
  // of two, 4.2 the latter alone. Pairs that are matched already are passed over.
  const char* const powers_of_two = "--SequentialMatching.quadratic_overlap";
  if (program.Takes(matcher, powers_of_two)) {
    matching.push_back({{powers_of_two}, "0"});
    colmap.Run("matches of neighbours", matcher, with_features(matching, matcher));
  }
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
