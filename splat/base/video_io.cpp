#include <cmath>
#include <filesystem>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/image_io.h"

namespace cosplat {
namespace {

// Containers may state any number of frames, or none, so the decodable frames are counted.
int CountFrames(const std::string& path) {
  cv::VideoCapture capture(path, cv::CAP_FFMPEG);
  int count = 0;
  while (capture.grab()) ++count;
  return count;
}

}  // namespace

struct VideoReader::Impl {
  std::string path;
  cv::VideoCapture capture;
  int count = 0;
  double frames_per_second = 0;
  int next = 0;  // index of the frame that read() returns
  std::mutex mutex;

  void Open() {
    next = 0;
    if (!capture.open(path, cv::CAP_FFMPEG)) throw Error(path, "cannot be opened as a video");
  }
};

VideoReader::VideoReader(const std::string& path) : impl_(std::make_unique<Impl>()) {
  QuietOpenCv();
  if (!std::filesystem::is_regular_file(path)) throw Error(path, "is not a file");
  impl_->path = path;
  impl_->Open();
  const double rate = impl_->capture.get(cv::CAP_PROP_FPS);
  impl_->frames_per_second = std::isfinite(rate) && rate > 0 ? rate : 0;
  impl_->count = CountFrames(path);
  if (impl_->count == 0) throw Error(path, "has no frame that can be decoded");
}

VideoReader::~VideoReader() = default;

int VideoReader::frame_count() const { return impl_->count; }
double VideoReader::frames_per_second() const { return impl_->frames_per_second; }

Image8 VideoReader::ReadFrame(int index) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  const std::string field = "frame " + std::to_string(index);
  if (index < 0 || index >= impl_->count)
    throw Error(impl_->path, field, "is missing, the video has " + std::to_string(impl_->count));
  // Seeking by number is unreliable between key frames; decoding from the start is exact.
  if (index < impl_->next) impl_->Open();
  cv::Mat bgr;
  while (impl_->next < index && impl_->capture.grab()) ++impl_->next;
  if (impl_->next != index || !impl_->capture.read(bgr) || bgr.type() != CV_8UC3)
    throw Error(impl_->path, field, "cannot be decoded");
  ++impl_->next;
  Image8 image(bgr.cols, bgr.rows, 3);
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.data.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return image;
}

struct VideoWriter::Impl {
  std::string path, temporary;
  cv::VideoWriter writer;
  int width = 0;
  int height = 0;
  int written = 0;
};

VideoWriter::VideoWriter(const std::string& path, int width, int height, double frames_per_second)
    : impl_(std::make_unique<Impl>()) {
  QuietOpenCv();
  const std::filesystem::path target(path);
  if (target.extension() != ".mp4") throw Error(path, "unknown video extension, expected .mp4");
  if (width < 2 || height < 2 || !(frames_per_second > 0))
    throw Error(path,
                "cannot hold frames of " + SizeText(width, height) + " at " +
                    std::to_string(frames_per_second) + " per second");
  impl_->path = path;
  impl_->temporary = TemporaryPath(path);
  impl_->width = width;
  impl_->height = height;
  const int fourcc = cv::VideoWriter::fourcc('m', 'p', '4', 'v');
  // MPEG-4 requires even sizes: an odd last row or column is dropped.
  const cv::Size size(width & ~1, height & ~1);
  if (!impl_->writer.open(impl_->temporary, cv::CAP_FFMPEG, fourcc, frames_per_second, size)) {
    std::error_code ignored;
    std::filesystem::remove(impl_->temporary, ignored);
    throw Error(path, "video cannot be written");
  }
}

VideoWriter::~VideoWriter() {
  impl_->writer.release();
  std::error_code ignored;
  std::filesystem::remove(impl_->temporary, ignored);  // already gone after Finish()
}

void VideoWriter::Write(const Image8& rgb) {
  if (rgb.width != impl_->width || rgb.height != impl_->height || rgb.channels != 3)
    throw Error(impl_->path,
                "frame " + std::to_string(impl_->written),
                "has size " + SizeText(rgb.width, rgb.height) + "x" + std::to_string(rgb.channels) +
                    ", expected " + SizeText(impl_->width, impl_->height) + "x3");
  const cv::Mat full(rgb.height, rgb.width, CV_8UC3, const_cast<uint8_t*>(rgb.data.data()));
  cv::Mat bgr;
  cv::cvtColor(full(cv::Rect(0, 0, rgb.width & ~1, rgb.height & ~1)), bgr, cv::COLOR_RGB2BGR);
  impl_->writer.write(bgr);
  ++impl_->written;
}

void VideoWriter::Finish() {
  impl_->writer.release();
  // The encoder does not report failures (such as a full disk), so the readable frames are counted.
  const int readable = CountFrames(impl_->temporary);
  if (readable != impl_->written || impl_->written == 0)
    throw Error(impl_->path,
                "video could not be written: " + std::to_string(readable) + " of " +
                    std::to_string(impl_->written) + " frames are readable");
  std::error_code code;
  std::filesystem::rename(impl_->temporary, impl_->path, code);
  if (code) throw Error(impl_->path, "cannot be written: " + code.message());
}

}  // namespace cosplat
