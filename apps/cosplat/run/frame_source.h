// The frames of a video file, or the images of a folder in the order of their names.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "flame/io/landmarks.h"
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
  int whole_width() const { return whole_width_; }  // before Crop
  int whole_height() const { return whole_height_; }
  double frames_per_second() const { return frames_per_second_; }  // 0: unknown
  // The stem of the image's file, or the frame's number in the video.
  std::string Name(int frame) const;
  // What a user should know of a video (VideoReader::notes).
  std::vector<std::string> notes() const;
  // Whether the frames have alpha: all of a video, or the first image some below 255.
  bool has_alpha() const { return has_alpha_; }
  // From here on the frames are this part of those in the file, which it must fit. Parts that
  // are read are kept, up to half a gigabyte of them, so that a video is not decoded each time.
  void Crop(const FrameCrop& crop);
  // 1 channel: the frame's alpha, 255 where it has none. Throws Error as the readers do.
  Image8 Alpha(int frame) const;
  // RGB. Cheapest in order. Throws Error as the readers do.
  Image8 Read(int frame) const;
  Image8 ReadWhole(int frame) const;  // without the crop

 private:
  std::unique_ptr<VideoReader> video_;
  std::vector<std::string> images_;  // paths, without a video
  int width_ = 0, height_ = 0, whole_width_ = 0, whole_height_ = 0;
  double frames_per_second_ = 0;
  bool has_alpha_ = false;
  std::optional<FrameCrop> crop_;
  mutable std::map<int, Image8> kept_;  // RGB
  mutable size_t kept_bytes_ = 0;
  mutable std::mutex mutex_;

  Image8 ReadAll(int frame) const;
  Image8 Part(const Image8& image) const;
};

}  // namespace cosplat
