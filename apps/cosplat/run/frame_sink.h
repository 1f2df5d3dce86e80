// Where rendered frames go: numbered PNGs in a folder, or a video file.
#pragma once

#include <memory>
#include <string>

#include "splat/base/image_io.h"

namespace cosplat {

constexpr double kFramesPerSecond = 25;

class FrameSink {
 public:
  // A path that ends in .mp4 is a video; anything else a folder.
  explicit FrameSink(std::string path);
  bool is_video() const { return is_video_; }
  // RGB; into a folder RGBA too. Video codecs want even sides: an odd last row or column is left
  // out there.
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
