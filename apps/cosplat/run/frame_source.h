// The frames of a video file, or the images of a folder in the order of their names.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "flame/io/landmarks.h"
#include "splat/media/image_io.h"

namespace cosplat {

// Whether bars beside the picture are looked for and left out: those that programs add to fill a
// frame of another shape, black, or the picture itself, enlarged and blurred.
enum class Bars { kFind, kKeep };
// The part of frames between two bars of one width, to the left and right or above and below; all
// of it if there are none. Nothing if the frames are too dark or soft to tell. A bar ends in a
// straight edge through the whole frame, and has little detail. frames: some, of one size and 3
// channels.
std::optional<Crop> PictureBetweenBars(const std::vector<Image8>& frames);

class FrameSource {
 public:
  // A folder's images are ordered as people count: 2.png before 10.png. Throws Error if
  // the path is neither a video nor a folder with images, or if their sizes differ.
  explicit FrameSource(const std::string& path, Bars bars = Bars::kFind);
  int count() const;
  int width() const { return width_; }
  int height() const { return height_; }
  const Crop& in_file() const { return in_file_; }  // with bars
  const Crop& picture() const { return picture_; }  // without, in the file's frames; before CropTo
  double frames_per_second() const { return frames_per_second_; }  // 0: unknown
  // The stem of the image's file, or the frame's number in the video.
  std::string Name(int frame) const;
  // CRC-32 of the video's file, or of the images' files in their order; none of what is no file, as
  // a pattern of names. Throws Error as ReadFile does.
  std::optional<uint32_t> Checksum() const;
  // What a user should know: of a video (VideoReader::notes), and of bars.
  std::vector<std::string> notes() const;
  // The frames that begin another shot, increasing (splat/media/frame_cuts.h). Reads a folder's
  // images.
  std::vector<int> Cuts() const;
  // From here on the file's frames end where this picture does.
  void EndAt(const Crop& picture);
  // From here on the frames are this part of the picture, which it must fit. Parts that
  // are read are kept, up to half a gigabyte of them, so that a video is not decoded each time.
  void CropTo(const FrameCrop& crop);
  // 1 channel: the frame's alpha. None if it has no alpha, or one that is opaque everywhere, which
  // is that of a format, as GIF's and screenshots'. Throws Error as the readers do.
  std::optional<Image8> Matte(int frame) const;
  // RGB. Cheapest in order. Throws Error as the readers do.
  Image8 Read(int frame) const;
  Image8 ReadWhole(int frame) const;  // without the crop

 private:
  std::unique_ptr<VideoReader> video_;
  std::vector<std::string> files_;  // of images; one of a video
  mutable std::optional<uint32_t> checksum_;
  int width_ = 0, height_ = 0;
  Crop in_file_, picture_;
  double frames_per_second_ = 0;
  bool has_alpha_ = false;  // some frames
  std::optional<FrameCrop> crop_;
  mutable std::map<int, Image8> kept_;  // RGB
  mutable size_t kept_bytes_ = 0;
  mutable std::mutex mutex_;

  void Open(const std::string& path);
  bool HasBars() const;
  Crop FindPicture() const;
  Image8 ReadAll(int frame) const;
  Image8 Part(const Image8& image) const;
};

// Reads frames in their order, some ahead of what is done with them in parallel. i: a place in
// `which`.
void ForFrames(const FrameSource& frames,
               const std::vector<int>& which,
               const std::function<void(size_t i, const Image8&)>& use,
               const std::function<void(int done)>& progress = {});

}  // namespace cosplat
