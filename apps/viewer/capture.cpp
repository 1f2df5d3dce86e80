#include "apps/viewer/capture.h"

#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>

#include "splat/base/files.h"

namespace cosplat::viewer {
namespace {

constexpr double kFramesPerSecond = 25;

}  // namespace

std::string CapturePath(const std::string& folder, const std::string& extension) {
  MakeDirectories(folder);
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char name[32];
  std::strftime(name, sizeof name, "/cosplat_%Y%m%d_%H%M%S", &local);
  std::string path = folder + name + extension;
  for (int i = 2; std::filesystem::exists(path); ++i)
    path = folder + name + "_" + std::to_string(i) + extension;
  return path;
}

VideoRecorder::VideoRecorder(const std::string& path, int width, int height)
    : path_(path),
      width_(width & ~1),
      height_(height & ~1),
      writer_(path, width_, height_, kFramesPerSecond) {}

VideoRecorder::~VideoRecorder() {
  if (writing_.valid()) writing_.wait();
}

void VideoRecorder::WaitForLast() {
  if (writing_.valid()) writing_.get();
}

void VideoRecorder::Offer(const Image8& rgba, double seconds) {
  const int due = int(std::floor(seconds * kFramesPerSecond)) + 1 - frames_;
  if (due < 1) return;
  WaitForLast();
  frames_ += due;
  const Crop even{0, 0, width_, height_};
  writing_ = std::async(std::launch::async, [this, due, rgb = Cropped(RgbOf(rgba), even)] {
    for (int i = 0; i < due; ++i) writer_.Write(rgb);
  });
}

void VideoRecorder::Finish() {
  WaitForLast();
  writer_.Finish();
}

}  // namespace cosplat::viewer
