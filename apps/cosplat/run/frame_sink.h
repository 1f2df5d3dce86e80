// Writes rendered frames as numbered PNGs in a folder or as a video file.
#pragma once

#include <memory>
#include <string>

#include "splat/media/image_io.h"

namespace cosplat {

constexpr double kFramesPerSecond = 25;

class FrameSink {
 public:
  // A path that ends in .mp4 is a video file, any other path a folder. Throws Error if it names an
  // image or a video of another kind.
  explicit FrameSink(std::string path);
  bool is_video() const { return is_video_; }
  // `image` is RGB; RGBA is allowed for folders too. Video codecs require even dimensions, so a
  // video omits an odd last row or column.
  void Write(const Image8& image);
  void Finish();
  int count() const { return count_; }

 private:
  std::string path_;
  bool is_video_;
  int count_ = 0;
  std::unique_ptr<VideoWriter> video_;
};

}  // namespace cosplat
