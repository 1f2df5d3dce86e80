#include "apps/cosplat/run/mediapipe.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/process.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

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
    throw Error("MediaPipe",
                "needs programs that are not installed: on Debian and Ubuntu `apt-get install" +
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
  const std::string cache = CacheFolder();
  const std::string wanted = program_folder + "/package-lock.json",
                    done = cache + "/installed.json";
  if (fs::exists(done) && ReadFile(done) == ReadFile(wanted)) return cache + "/node_modules";
  if (!quiet)
    std::fprintf(stderr,
                 "Installing MediaPipe's face mesh and selfie segmentation (npm, once): %s\n",
                 cache.c_str());
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

}  // namespace

std::vector<std::string> Mediapipe::Command(const std::string& program,
                                            const std::vector<std::string>& options) const {
  std::vector<std::string> all{
      node, folder + "/" + program, "--chromium", chromium, "--modules", modules};
  all.insert(all.end(), options.begin(), options.end());
  return all;
}

Mediapipe FindMediapipe(bool quiet) {
  const Programs programs = FindPrograms();
  const std::string folder = ProgramFolder();
  return {programs.node, programs.chromium, ModulesFolder(programs, folder, quiet), folder};
}

}  // namespace cosplat
