// Writes rendered frames as numbered PNGs in a folder or as a video file.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "splat/media/image_io.h"

namespace cosplat {

constexpr double kFramesPerSecond = 25;  // of a video that has no rate of its own

class FrameSink {
 public:
  // A path that ends in .mp4 is a video file, any other path a folder. Throws Error if it names an
  // image or a video of another kind. sound: of a video.
  explicit FrameSink(std::string path,
                     double frames_per_second = kFramesPerSecond,
                     std::optional<Sound> sound = {});
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
  double frames_per_second_;
  std::optional<Sound> sound_;  // until the video begins
  std::unique_ptr<VideoWriter> video_;
};

}  // namespace cosplat
