// MP4 files by FFmpeg's libraries.
#include <filesystem>
#include <optional>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/media/image_io.h"
#include "splat/media/video_stream.h"

namespace cosplat {

struct VideoWriter::Impl {
  std::string path, temporary;
  std::optional<libav::VideoStream> stream;
  int64_t written = 0;

  ~Impl() {
    stream.reset();
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);  // already gone after Finish()
  }
};

VideoWriter::VideoWriter(const std::string& path,
                         int width,
                         int height,
                         double frames_per_second,
                         std::optional<Sound> sound)
    : impl_(std::make_unique<Impl>()) {
  const std::filesystem::path target(path);
  if (target.extension() != ".mp4") throw Error(path, "unknown video extension, expected .mp4");
  if (width < 2 || height < 2 || !(frames_per_second > 0))
    throw Error(path,
                "cannot hold frames of " + SizeText(width, height) + " at " +
                    std::to_string(frames_per_second) + " per second");
  impl_->path = path;
  impl_->temporary = TemporaryPath(path);
  impl_->stream.emplace(path,
                        "mp4",
                        libav::FileUrl(impl_->temporary),
                        width,
                        height,
                        frames_per_second,
                        libav::VideoStream::For::kFile,
                        std::move(sound));
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::Write(const Image8& rgb) { impl_->stream->Write(rgb, impl_->written++); }

void VideoWriter::Finish() {
  Impl& video = *impl_;
  if (video.written == 0) throw Error(video.path, "video could not be written: it has no frame");
  video.stream->Finish();
  std::error_code code;
  std::filesystem::rename(video.temporary, video.path, code);
  if (code) throw Error(video.path, "cannot be written: " + code.message());
}

}  // namespace cosplat
