#include "apps/cosplat/run/frame_sink.h"

#include <cctype>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// Whether frames go into a video. Throws Error for a file of another kind, which would else become
// a folder of that name.
bool IsVideo(const std::string& path) {
  const std::string extension = LowerCase(std::filesystem::path(path).extension().string());
  for (const char* other : {".avi", ".gif", ".jpg", ".jpeg", ".mkv", ".mov", ".png", ".webm"})
    if (extension == other && !std::filesystem::is_directory(path))
      throw Error(path, "is neither a folder nor a file that ends in .mp4");
  return extension == ".mp4";
}

}  // namespace

FrameSink::FrameSink(std::string path, double frames_per_second, std::optional<Sound> sound)
    : path_(std::move(path)),
      is_video_(IsVideo(path_)),
      frames_per_second_(frames_per_second),
      sound_(std::move(sound)) {
  if (!is_video_) MakeDirectories(path_);
}

void FrameSink::Write(const Image8& image) {
  if (is_video_) {
    const int width = image.width & ~1, height = image.height & ~1;
    if (width == 0 || height == 0)
      throw Error(path_, "frame", "is too small for a video: one pixel");
    if (!video_)
      video_ = std::make_unique<VideoWriter>(
          path_, width, height, frames_per_second_, std::exchange(sound_, {}));
    video_->Write(Cropped(RgbOf(image), {0, 0, width, height}));
  } else {
    WriteImage(Format("{}/{:05d}.png", path_, count_), image);
  }
  ++count_;
}

void FrameSink::Finish() {
  if (count_ == 0) throw Error(path_, "there is no frame to write");
  if (video_) video_->Finish();
  if (!video_ && std::filesystem::exists(Format("{}/{:05d}.png", path_, count_)))
    std::fprintf(stderr,
                 "cosplat: %s: frames from %05d.png on are of an earlier run\n",
                 path_.c_str(),
                 count_);
}

}  // namespace cosplat
