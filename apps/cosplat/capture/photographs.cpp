#include "apps/cosplat/capture/photographs.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <tuple>

#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/progress_bar.h"
#include "splat/base/data_files.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

std::string LowerExtension(const fs::path& path) { return LowerCase(path.extension().string()); }

// What COLMAP reads whatever its version; others become PNG.
bool IsJpegOrPng(const fs::path& path) {
  const std::string extension = LowerExtension(path);
  return extension == ".jpg" || extension == ".jpeg" || extension == ".png";
}

// What cameras and phones write and nothing here reads.
bool IsUnreadPhotograph(const fs::path& path) {
  const std::string extension = LowerExtension(path);
  for (const char* other :
       {".heic", ".heif", ".avif", ".dng", ".cr2", ".cr3", ".nef", ".arw", ".raf", ".orf", ".rw2"})
    if (extension == other) return true;
  return false;
}

// By name, with those that cannot be read, whose error says so, unless a readable one beside them
// is the same photograph.
std::vector<std::string> PhotographsIn(const std::string& folder) {
  std::vector<std::string> names, unread;
  std::set<std::string> stems;
  for (auto entry = fs::recursive_directory_iterator(folder); entry != fs::end(entry); ++entry) {
    const std::string name = entry->path().filename().string();
    if (entry->is_directory() && (name == "mask" || name == "masks"))
      entry.disable_recursion_pending();
    if (!entry->is_regular_file()) continue;
    const std::string path = entry->path().lexically_relative(folder).generic_string();
    if (IsUnreadPhotograph(path)) {
      unread.push_back(path);
    } else if (IsImageName(path)) {
      names.push_back(path);
      stems.insert(fs::path(path).replace_extension().string());
    }
  }
  for (const std::string& path : unread)
    if (!stems.count(fs::path(path).replace_extension().string())) names.push_back(path);
  std::sort(names.begin(), names.end());
  if (names.empty()) throw Error(folder, "contains no photographs (.jpg, .png, .webp, .tif)");
  return names;
}

Json FileIdentity(const std::string& path) {
  const auto changed = fs::last_write_time(path).time_since_epoch().count();
  return {{"path", fs::absolute(path).lexically_normal().string()},
          {"bytes", fs::file_size(path)},
          {"changed", int64_t(changed)}};
}

struct Photograph {
  std::string name, stored_name;
  int width, height;  // px, upright
  ExifInfo exif;
};

Photograph Inspect(const std::string& folder, const std::string& name) {
  const std::string path = folder + "/" + name;
  const std::vector<char> bytes = ReadFile(path);
  CheckImageIsComplete(path, bytes);
  if (LacksJpegEnd(bytes)) ReadImage(path);  // throws Error if it is truncated
  ImageInfo info;
  if (!ParseImageHeader(bytes, info)) {
    const Image8 image = ReadImage(path);  // throws Error if it is none
    info.width = image.width;
    info.height = image.height;
  }
  const ExifInfo exif = ParseExif(bytes);
  if (exif.orientation >= 5) std::swap(info.width, info.height);
  return {name, IsJpegOrPng(name) ? name : name + ".png", info.width, info.height, exif};
}

void LinkPhotograph(const std::string& path,
                    const Photograph& photograph,
                    const std::string& target) {
  if (photograph.exif.orientation != 1 || photograph.stored_name != photograph.name)
    return WriteImage(target, Upright(ReadImage(path), photograph.exif.orientation));
  std::error_code code;
  fs::create_symlink(fs::absolute(path), target, code);
  if (code) throw Error(target, "cannot be linked: " + code.message());
}

void GatherFolder(const std::string& source, const std::string& folder, Photographs& result) {
  std::vector<Photograph> usable;
  std::map<std::tuple<int, int, double>, int> lenses;  // numbered in order of appearance
  for (const std::string& name : PhotographsIn(source)) {
    const std::string problem = Problem([&] { usable.push_back(Inspect(source, name)); });
    if (!problem.empty()) {
      result.skipped.push_back({name, problem});
      continue;
    }
    const Photograph& p = usable.back();
    lenses.try_emplace({p.width, p.height, p.exif.focal_length}, int(lenses.size()) + 1);
    result.width = std::max(result.width, p.width);
    result.height = std::max(result.height, p.height);
  }
  CheckSkipped(source, usable.size(), result.skipped);
  result.lenses = int(lenses.size());
  for (const Photograph& p : usable) {
    const int lens = lenses.at({p.width, p.height, p.exif.focal_length});
    const std::string below = result.lenses == 1 ? "" : std::to_string(lens) + "/";
    const std::string stored = below + p.stored_name;
    MakeDirectories(fs::path(folder + "/" + stored).parent_path().string());
    LinkPhotograph(source + "/" + p.name, p, folder + "/" + stored);
    result.names.push_back(stored);
  }
  std::sort(result.names.begin(), result.names.end());
}

// Variance of the Laplacian of the green channel (Pech-Pacheco et al. 2000): comparable between
// images of the same scene and size, where motion blur lowers it. 0 for images under 3x3 px.
double Sharpness(const Image8& image) {
  if (image.width < 3 || image.height < 3) return 0;
  const int green = image.channels < 3 ? 0 : 1;
  double sum = 0, squares = 0;
  for (int y = 1; y + 1 < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x) {
      const double laplacian = image.at(x - 1, y, green) + image.at(x + 1, y, green) +
                               image.at(x, y - 1, green) + image.at(x, y + 1, green) -
                               4 * image.at(x, y, green);
      sum += laplacian;
      squares += laplacian * laplacian;
    }
  const double n = double(image.width - 2) * (image.height - 2);
  return squares / n - (sum / n) * (sum / n);
}

// Splits the video into `frames` intervals of equal length (fewer if it has fewer frames), and
// writes the sharpest frame of each to folder/frame_NNNNNN.jpg, by its number in the video. Throws
// Error as VideoReader does.
void GatherFrames(const std::string& video,
                  int frames,
                  const std::string& folder,
                  bool quiet,
                  Photographs& result) {
  const auto progress = ShowProgress("frames", "read", quiet, OffTerminal::kLines);
  VideoReader reader(video);
  PrintNotes(reader.notes());
  const int total = reader.frame_count();
  const int intervals = std::min(frames, total);
  result.is_video = true;
  for (int i = 0, next = 0; i < intervals; ++i) {
    const int end = int(int64_t(i + 1) * total / intervals);
    Image8 best;
    int best_index = 0;
    double sharpest = -1;
    for (; next < end; ++next) {
      Image8 frame = reader.ReadFrame(next);
      const double sharpness = Sharpness(frame);
      if (sharpness > sharpest) {
        sharpest = sharpness;
        best = std::move(frame);
        best_index = next;
      }
      progress(next + 1, total);
    }
    const std::string name = Format("frame_{:06d}.jpg", best_index);
    WriteImage(folder + "/" + name, best);
    result.names.push_back(name);
  }
  const ImageInfo info = ReadImageInfo(folder + "/" + result.names[0]);
  result.width = info.width;
  result.height = info.height;
}

}  // namespace

Json IdentityOf(const std::string& source) {
  Json files = Json::array();
  if (fs::is_directory(source)) {
    for (const std::string& name : PhotographsIn(source))
      files.push_back(FileIdentity(source + "/" + name));
  } else if (fs::is_regular_file(source)) {
    files.push_back(FileIdentity(source));
  } else {
    throw Error(source, "is neither a folder of photographs nor a video file");
  }
  return files;
}

Photographs GatherPhotographs(const std::string& source,
                              int frames,
                              const std::string& folder,
                              bool quiet) {
  Photographs result;
  MakeDirectories(folder);
  if (fs::is_directory(source)) {
    GatherFolder(source, folder, result);
  } else {
    GatherFrames(source, frames, folder, quiet, result);
  }
  if (result.names.size() < kMinPhotographs)
    throw Error(source,
                "has " + std::to_string(result.names.size()) +
                    (result.is_video ? " frames" : " photographs") + ", expected at least " +
                    std::to_string(kMinPhotographs) + ", of the same scene from different places");
  return result;
}

Json ToJson(const Photographs& p) {
  Json skipped = Json::array();
  for (const SkippedFrame& frame : p.skipped) skipped.push_back({frame.name, frame.reason});
  return {{"names", p.names},
          {"lenses", p.lenses},
          {"is_video", p.is_video},
          {"size", {p.width, p.height}},
          {"skipped", skipped}};
}

Photographs PhotographsFromJson(const JsonField& json) {
  Photographs p;
  for (size_t i = 0; i < json["names"].size(); ++i) p.names.push_back(json["names"][i].String());
  p.lenses = json["lenses"].Integer();
  p.is_video = json.raw().value("is_video", false);
  p.width = json["size"][0].Integer();
  p.height = json["size"][1].Integer();
  for (size_t i = 0; i < json["skipped"].size(); ++i)
    p.skipped.push_back({json["skipped"][i][0].String(), json["skipped"][i][1].String()});
  return p;
}

}  // namespace cosplat
