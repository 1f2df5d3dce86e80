// Screenshots and videos of the viewer's image.
#pragma once

#include <future>
#include <string>

#include "splat/media/image_io.h"

namespace cosplat::viewer {

// FOLDER/cosplat_DATE_TIME.EXTENSION in local time; with a suffix _2, _3, ... if that file exists.
std::string CapturePath(const std::string& folder, const std::string& extension);

// A 25 fps video of images that arrive at irregular times: each is shown from its own time to that
// of the next one. Encodes in the background.
class VideoRecorder {
 public:
  // Odd dimensions are reduced to even ones; both must be at least 2. Throws Error.
  VideoRecorder(const std::string& path, int width, int height);
  ~VideoRecorder();

  int width() const { return width_; }
  int height() const { return height_; }
  const std::string& path() const { return path_; }
  int frames() const { return frames_; }

  // Adds the image shown at `seconds` since the start. rgba: opaque, of the video's size or one
  // pixel larger in each dimension. Throws Error with the problem of an earlier write.
  void Offer(const Image8& rgba, double seconds);
  // Finishes the file, which then has its final name. Throws Error.
  void Finish();

 private:
  void WaitForLast();

  std::string path_;
  int width_, height_, frames_ = 0;
  VideoWriter writer_;
  std::future<void> writing_;  // of the last image
};

}  // namespace cosplat::viewer
