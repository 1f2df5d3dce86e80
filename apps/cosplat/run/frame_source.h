// The frames of a video file, or the images of a folder in the order of their names.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "splat/media/image_io.h"

namespace cosplat {

class FrameSource {
 public:
  // A folder's images are ordered as people count: 2.png before 10.png. Throws Error if
  // the path is neither a video nor a folder with images, or if their sizes differ.
  explicit FrameSource(const std::string& path);
  int count() const;
  int width() const { return width_; }
  int height() const { return height_; }
  double frames_per_second() const { return frames_per_second_; }  // 0: unknown
  // The stem of the image's file, or the frame's number in the video.
  std::string Name(int frame) const;
  // What a user should know of a video (VideoReader::notes).
  std::vector<std::string> notes() const;
  // Whether the frames have alpha: all of a video, or the first image some below 255.
  bool has_alpha() const { return has_alpha_; }
  // 1 channel: the frame's alpha, 255 where it has none. Throws Error as the readers do.
  Image8 Alpha(int frame) const;
  // RGB. Cheapest in order. Throws Error as the readers do.
  Image8 Read(int frame) const;

 private:
  std::unique_ptr<VideoReader> video_;
  std::vector<std::string> images_;  // paths, without a video
  int width_ = 0, height_ = 0;
  double frames_per_second_ = 0;
  bool has_alpha_ = false;

  Image8 ReadAll(int frame) const;
};

}  // namespace cosplat
