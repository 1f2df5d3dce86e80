#include "apps/cosplat/run/face_detector.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "apps/cosplat/run/process.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

std::string MakeScratchFolder() {
  std::string name = (fs::temp_directory_path() / "cosplat-landmarks-XXXXXX").string();
  if (!mkdtemp(name.data())) throw Error(name, "cannot be created");
  return name;
}

struct Programs {
  std::string node, npm, chromium;
};

Programs FindPrograms() {
  Programs found{FindProgram("node"), FindProgram("npm"), ""};
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
    if (found.chromium.empty()) found.chromium = FindProgram(name);
  std::string missing;
  for (const auto& [name, path] : {std::pair("nodejs", found.node),
                                   std::pair("npm", found.npm),
                                   std::pair("chromium", found.chromium)})
    if (path.empty()) missing += std::string(" ") + name;
  if (!missing.empty())
    throw Error("landmarks",
                "need programs that are not installed: on Debian and Ubuntu `apt-get install" +
                    missing + "` does so");
  return found;
}

// Where detect.mjs is: beside the installed command, or in the source folder.
std::string ProgramFolder() {
  std::error_code ignored;
  const fs::path self = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = self.parent_path().parent_path() / "share/cosplat/landmarks";
  return fs::exists(installed / "detect.mjs") ? installed.string() : COSPLAT_LANDMARKS_FOLDER;
}

std::string CacheFolder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache)
    return std::string(cache) + "/cosplat/landmarks";
  const char* home = std::getenv("HOME");
  if (!home || !*home) throw Error("HOME", "is not set: MediaPipe's packages need a cache folder");
  return std::string(home) + "/.cache/cosplat/landmarks";
}

// The folder of MediaPipe's packages as the lock file names them; installs them if they are not
// there. An interrupted installation lacks the copy of the lock file, and is done again.
std::string ModulesFolder(const Programs& programs, const std::string& program_folder, bool quiet) {
  const std::string cache = CacheFolder(), lock = cache + "/package-lock.json";
  const std::string wanted = program_folder + "/package-lock.json",
                    done = cache + "/installed.json";
  if (fs::exists(done) && ReadFile(done) == ReadFile(wanted)) return cache + "/node_modules";
  if (!quiet)
    std::printf("Installing MediaPipe's face mesh and selfie segmentation (npm, once): %s\n",
                cache.c_str());
  std::fflush(stdout);
  MakeDirectories(cache);
  const auto replace = fs::copy_options::overwrite_existing;
  for (const char* name : {"package.json", "package-lock.json"})
    fs::copy_file(program_folder + "/" + name, cache + "/" + name, replace);
  std::string last;
  const int status = RunProcess(
      {programs.npm, "ci", "--prefix", cache, "--no-audit", "--no-fund", "--loglevel", "error"},
      {},
      [&](const std::string& line) {
        if (!line.empty()) last = line;
      });
  if (status != 0)
    throw Error("npm", ExitText(status) + (last.empty() ? "" : ": " + last) + " (" + cache + ")");
  fs::copy_file(wanted, done, replace);
  return cache + "/node_modules";
}

DetectedFace FaceIn(const JsonField& field) {
  DetectedFace face;
  for (size_t p = 0; p < field.size(); ++p)
    face.points.push_back({field[p][0].Number(), field[p][1].Number()});
  return face;
}

}  // namespace

FaceDetector::FaceDetector(int width, int height, bool quiet) : width_(width), height_(height) {
  const Programs programs = FindPrograms();
  node_ = programs.node, chromium_ = programs.chromium;
  modules_ = ModulesFolder(programs, ProgramFolder(), quiet);
  folder_ = MakeScratchFolder();
}

FaceDetector::~FaceDetector() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void FaceDetector::Add(size_t image, const Image8& pixels) const {
  WriteImage(File(std::to_string(image) + ".jpg"), pixels);
}

void FaceDetector::Run(const std::vector<double>& milliseconds,
                       bool mattes,
                       const std::function<void(int done)>& progress) {
  WriteFileAtomically(File("times.json"), Json(milliseconds).dump());
  std::string last;
  const int status = RunProcess({node_,
                                 ProgramFolder() + "/detect.mjs",
                                 "--chromium",
                                 chromium_,
                                 "--modules",
                                 modules_,
                                 "--frames",
                                 folder_,
                                 "--jobs",
                                 mattes ? "face,matte" : "face,face",
                                 "--width",
                                 std::to_string(width_),
                                 "--height",
                                 std::to_string(height_)},
                                {},
                                [&](const std::string& line) {
                                  int done = 0;
                                  if (std::sscanf(line.c_str(), "frame %d", &done) == 1)
                                    progress(std::clamp(done, 0, int(milliseconds.size())));
                                  else if (!line.empty())
                                    last = line;
                                });
  if (status != 0)
    throw Error("landmarks", "node " + ExitText(status) + (last.empty() ? "" : ": " + last));
}

std::vector<std::vector<DetectedFace>> FaceDetector::Faces() const {
  const JsonField found(File("faces.json"), ReadJson(File("faces.json")));
  std::vector<std::vector<DetectedFace>> faces(found.size());
  for (size_t f = 0; f < faces.size(); ++f)
    for (size_t i = 0; i < found[f].size(); ++i) faces[f].push_back(FaceIn(found[f][i]));
  return faces;
}

// The browser's mattes are a byte per pixel, rows from the top.
Image8 FaceDetector::Matte(size_t image) const {
  const std::string path = File(std::to_string(image) + ".matte");
  const std::vector<char> bytes = ReadFile(path);
  Image8 matte(width_, height_, 1);
  if (bytes.size() != matte.data.size())
    throw Error(path, Format("has {} bytes, expected {}", bytes.size(), matte.data.size()));
  std::copy(bytes.begin(), bytes.end(), matte.data.begin());
  return matte;
}

Image8 FaceDetector::Added(size_t image) const {
  return ReadImage(File(std::to_string(image) + ".jpg"));
}

}  // namespace cosplat
