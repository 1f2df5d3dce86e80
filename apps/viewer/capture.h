// Images and videos of what the viewer shows.
#pragma once

#include <future>
#include <string>

#include "splat/base/image_io.h"

namespace cosplat::viewer {

// FOLDER/cosplat_DATE_TIME.EXTENSION by the local clock; with _2, _3, ... where that is taken.
std::string CapturePath(const std::string& folder, const std::string& extension);

// A video at 25 frames per second of images that come when they come: each is shown from its time
// to the next one's. Encodes beside the caller.
class VideoRecorder {
 public:
  // Sides are made even by leaving out a last row or column; at least 2. Throws Error.
  VideoRecorder(const std::string& path, int width, int height);
  ~VideoRecorder();

  int width() const { return width_; }
  int height() const { return height_; }
  const std::string& path() const { return path_; }
  int frames() const { return frames_; }

  // What is to be seen at `seconds` since the beginning. rgba: of the video's size or one more each
  // way, opaque. Throws Error with what went wrong before.
  void Offer(const Image8& rgba, double seconds);
  // The file then has its name. Throws Error.
  void Finish();

 private:
  void WaitForLast();

  std::string path_;
  int width_, height_, frames_ = 0;
  VideoWriter writer_;
  std::future<void> writing_;  // of the last image
};

}  // namespace cosplat::viewer
