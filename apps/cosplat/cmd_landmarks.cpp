// cosplat landmarks: the points of the face in each frame of a video, and mattes, by MediaPipe in
// headless Chromium.
//
// FrameSource -> apps/landmarks/detect.mjs (node, Chromium) -> a landmark file with its mattes,
// which `cosplat track` reads.
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <vector>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/frame_source.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/process.h"
#include "apps/cosplat/run/progress_bar.h"
#include "flame/fit/landmark_scores.h"
#include "flame/io/landmarks.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// A folder that is removed with all that is in it.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "cosplat-landmarks-XXXXXX").string();
    if (!mkdtemp(name.data())) throw Error(name, "cannot be created");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

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

// Writes the frames for the browser: without an alpha channel, which would hide what is under it.
void WriteFrames(const FrameSource& frames, const std::string& folder, bool quiet) {
  ProgressBar bar("decode", frames.count(), quiet);
  constexpr int kAhead = 16;
  for (int begin = 0; begin < frames.count(); begin += kAhead) {
    std::vector<Image8> images;
    const int end = std::min(begin + kAhead, frames.count());
    for (int f = begin; f < end; ++f) images.push_back(frames.Read(f));
    tbb::parallel_for(begin, end, [&](int f) {
      WriteImage(folder + "/" + std::to_string(f) + ".jpg", images[size_t(f - begin)]);
    });
    bar.Update(end, "frames");
  }
}

void Detect(const Programs& programs,
            const std::string& modules,
            const FrameSource& frames,
            const std::string& folder,
            bool quiet) {
  ProgressBar bar("landmarks", frames.count(), quiet, OffTerminal::kLines);
  std::string last;
  const int status = RunProcess({programs.node,
                                 ProgramFolder() + "/detect.mjs",
                                 "--chromium",
                                 programs.chromium,
                                 "--modules",
                                 modules,
                                 "--frames",
                                 folder,
                                 "--count",
                                 std::to_string(frames.count()),
                                 "--width",
                                 std::to_string(frames.width()),
                                 "--height",
                                 std::to_string(frames.height())},
                                {},
                                [&](const std::string& line) {
                                  int done = 0;
                                  if (std::sscanf(line.c_str(), "frame %d", &done) == 1)
                                    bar.Update(std::clamp(done, 0, frames.count()), "frames");
                                  else if (!line.empty())
                                    last = line;
                                });
  if (status != 0)
    throw Error("landmarks", "node " + ExitText(status) + (last.empty() ? "" : ": " + last));
}

DetectedFace FaceIn(const JsonField& field) {
  DetectedFace face;
  for (size_t p = 0; p < field.size(); ++p)
    face.points.push_back({field[p][0].Number(), field[p][1].Number()});
  return face;
}

LandmarkVideo FacesIn(const std::string& path,
                      const FrameSource& frames,
                      const std::string& source) {
  const JsonField found(path, ReadJson(path));
  LandmarkVideo video;
  video.source = source;
  video.width = frames.width(), video.height = frames.height();
  video.frames_per_second = frames.frames_per_second();
  for (int f = 0; f < frames.count(); ++f) {
    video.frames.push_back({frames.Name(f), f, {}, ""});
    const JsonField faces = found[size_t(f)];
    for (size_t i = 0; i < faces.size(); ++i) video.frames.back().faces.push_back(FaceIn(faces[i]));
  }
  return video;
}

// The browser's mattes are a byte per pixel, rows from the top.
Image8 ReadMatte(const std::string& path, const LandmarkVideo& video) {
  const std::vector<char> bytes = ReadFile(path);
  Image8 matte(video.width, video.height, 1);
  if (bytes.size() != matte.data.size())
    throw Error(path, Format("has {} bytes, expected {}", bytes.size(), matte.data.size()));
  std::copy(bytes.begin(), bytes.end(), matte.data.begin());
  return matte;
}

// Frames' own alpha counts before what the browser found in `from`.
void WriteMattes(const FrameSource& frames,
                 const std::string& from,
                 const std::string& to,
                 LandmarkVideo& video) {
  MakeDirectories(to);
  const auto write = [&](size_t f) {
    const Image8 matte = frames.has_alpha() ? frames.Alpha(int(f))
                                            : ReadMatte(Format("{}/{}.matte", from, f), video);
    video.frames[f].matte = to + "/" + video.frames[f].name + ".png";
    WriteImage(video.frames[f].matte, matte);
  };
  if (!frames.has_alpha()) return tbb::parallel_for(size_t(0), video.frames.size(), write);
  for (size_t f = 0; f < video.frames.size(); ++f) write(f);  // a video is read in its order
}

}  // namespace

void DetectLandmarks(const LandmarkRunOptions& o) {
  const FrameSource frames(o.source);
  PrintNotes(frames.notes());
  const Programs programs = FindPrograms();
  const std::string modules = ModulesFolder(programs, ProgramFolder(), o.quiet);
  const ScratchFolder scratch;
  WriteFrames(frames, scratch.path(), o.quiet);
  Detect(programs, modules, frames, scratch.path(), o.quiet);
  LandmarkVideo video = FacesIn(scratch.path() + "/faces.json", frames, o.source);
  const size_t seen = size_t(std::count_if(
      video.frames.begin(), video.frames.end(), [](const auto& f) { return !f.faces.empty(); }));
  if (seen == 0) throw Error(o.source, "has no face in any of its frames");
  WriteMattes(frames, scratch.path(), (fs::path(o.out).parent_path() / "mattes").string(), video);
  AddScores(video);
  WriteLandmarks(o.out, video);
  if (!o.quiet) std::printf("faces in %zu of %d frames: %s\n", seen, frames.count(), o.out.c_str());
}

void AddLandmarks(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "landmarks", "find the points of the face in a video; needs node and Chromium");
  const auto o = std::make_shared<LandmarkRunOptions>();
  command->add_option("video", o->source, "a video file, or a folder of images")->required();
  command->add_option("-o,--out", o->out, "file to write, .json; mattes/ goes beside it")
      ->required();
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { DetectLandmarks(*o); });
}

}  // namespace cosplat
