// Image and video files. Within the libraries, only image_io.cpp includes OpenCV for pixel data,
// and only those that include libav.h FFmpeg's libraries.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/media/sound.h"

namespace cosplat {

// Width and height in pixels and number of channels (1, 3 or 4) of an image file.
struct ImageInfo {
  int width = 0;
  int height = 0;
  int channels = 0;
  int orientation = 1;  // EXIF's: see Upright

  // As a viewer shows it.
  ImageInfo Upright() const {
    return orientation < 5 ? ImageInfo{width, height, channels}
                           : ImageInfo{height, width, channels};
  }
};

// Reads only the header of PNG and JPEG files; throws Error as ReadImage does.
ImageInfo ReadImageInfo(const std::string& path);

// Reads PNG, JPEG, ... as 8-bit RGB (3 channels), RGBA (4) or grey (1); 16-bit files are scaled
// down. EXIF orientation is ignored, as in COLMAP. Throws Error if the file is missing, damaged or
// truncated (for which decoders would return a partial image).
Image8 ReadImage(const std::string& path);

// The image as viewers show it: turned as its EXIF orientation says.
Image8 ReadUpright(const std::string& path);

// What a camera wrote into a JPEG, PNG, WebP or TIFF about the shot (EXIF 2.3, CIPA DC-008).
struct ExifInfo {
  int orientation = 1;        // 1 to 8, see Upright
  double focal_length = 0;    // mm; 0: not stated
  int extra_samples = 0;      // TIFF 6.0's: 1 if colours are multiplied by alpha, 2 if they are not
  bool is_raw = false;        // a TIFF of sensor values, whose first image is a preview of them
  size_t orientation_at = 0;  // where a TIFF has its orientation, in bytes; 0: nowhere, or no TIFF
};

// `bytes`: a whole file or its beginning. What is absent or damaged keeps its default.
ExifInfo ParseExif(const std::vector<char>& bytes);

// The image as it is meant to be seen: turned by a quarter clockwise for orientation 6, by half for
// 3, counter-clockwise for 8; 2, 4, 5 and 7 are mirrored.
Image8 Upright(const Image8& image, int orientation);

// What a mask's file means. People's masks are 0 and 255, 0 and 1, labels, colours, or the alpha
// channel of a cut-out image; all of them become one channel of coverage.

// Whether an image's alpha says anything: it has four channels, not all of them opaque.
bool SaysAlpha(const Image8& image);

// RGB of an RGB or RGBA image.
Image8 RgbOf(const Image8& image);
// One of an image's channels.
Image8 ChannelOf(const Image8& image, int channel);

// One channel, 0 to 255: of an alpha that is not opaque everywhere, else of the colours. By the
// first of these that holds:
//   labels (none above 31, as 0 and 1; or at most 64 colours): all but black is 255;
//   two values, of which one is 0: the other is 255;
//   else the brightest channel, so that soft edges stay soft.
Image8 MatteOf(const Image8& mask);

// Encodes 1, 3 or 4 channels as PNG or 1 or 3 as JPEG, chosen by the extension of `path`, which is
// otherwise used only in errors.
std::vector<uint8_t> EncodeImage(const std::string& path, const Image8& image);

// Encodes and writes an image through a temporary file.
void WriteImage(const std::string& path, const Image8& image);
void WriteImage(const std::string& path, const Image& image);  // clamped to [0, 1], rounded

// Clamps to [0, 1] and rounds; throws Error naming the pixel if a value is NaN.
Image8 ToBytes(const Image& image);
Image ToFloat(const Image8& image);

// Averages over the covered source area (cv::INTER_AREA); width and height >= 1. With a fourth
// channel, colour is weighted by alpha so that the background under alpha 0 does not bleed in.
Image8 ResizeByArea(const Image8& image, int width, int height);

// kBrown {k1,k2,p1,p2,k3,k4,k5,k6} (OpenCV's order), kFisheye {k1,k2,k3,k4} or kDivision {k}
// (Fitzgibbon 2001: the ray of the distorted point d is d / (1 + k |d|²)).
struct Distortion {
  enum class Model { kNone, kBrown, kFisheye, kDivision } model = Model::kNone;
  double k[8] = {0, 0, 0, 0, 0, 0, 0, 0};
};
// Removes lens distortion: resamples `image` (bilinear, alpha-weighted; edge pixels are repeated
// outside) as if taken by the pinhole camera `target` at the same pose.
Image8 Undistort(const Image8& image,
                 const Camera& source,
                 const Distortion& distortion,
                 const Camera& target);

// Maps `points` (px in `target`) along their pinhole rays to the distorted image `source`, px.
std::vector<std::array<double, 2>> DistortedPixels(
    const Camera& source,
    const Distortion& distortion,
    const Camera& target,
    const std::vector<std::array<double, 2>>& points);

// Frames of a video file as a player shows them: turned as the file's display matrix says, with
// square pixels, all of the first frame's size. What cannot be decoded is left out. Thread-safe:
// calls are serialised.
class VideoReader {
 public:
  explicit VideoReader(const std::string& path);  // decodes all of it once; throws Error
  ~VideoReader();
  int frame_count() const;
  // As the container states it, or where the frames' time stamps say otherwise, theirs on average;
  // 0 if there is neither.
  double frames_per_second() const;
  bool has_alpha() const;
  // What a user should know: frames scaled, packets left out, HDR.
  const std::vector<std::string>& notes() const;
  // The frames that begin another shot, increasing (splat/media/frame_cuts.h).
  const std::vector<int>& cuts() const;
  // RGB, or RGBA (straight) if the video has alpha; cheap for index = last + 1, whereas an earlier
  // index decodes from the start. Throws Error, also for a frame of another shape than the first.
  Image8 ReadFrame(int index);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// MP4 writer (H.264, or MPEG-4 where FFmpeg has no encoder of it); the file appears under its final
// name once Finish() succeeds.
class VideoWriter {
 public:
  // sound: beside the frames, as long as they last.
  VideoWriter(const std::string& path,
              int width,
              int height,
              double frames_per_second,
              std::optional<Sound> sound = {});
  ~VideoWriter();
  void Write(const Image8& rgb);
  void Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Checks of PNG and JPEG files without decoding. Decoders return partial images for truncated
// files; walking the file's structure detects the truncation.

// Fills `info` and returns true if `bytes` (a whole file or its beginning) is a PNG or JPEG with a
// complete header.
bool ParseImageHeader(const std::vector<char>& bytes, ImageInfo& info);

// Whether a baseline JPEG lacks its end-of-image marker, as those of some phones do that end in
// their maker's own data: only decoding tells whether it is whole.
bool LacksJpegEnd(const std::vector<char>& bytes);

// Throws Error(path, ...) if a PNG lacks chunks up to IEND or a critical chunk fails its CRC, if a
// progressive JPEG lacks its end-of-image marker, or if either has more than 2^28 pixels or more
// than its bytes can hold. Other file types pass.
void CheckImageIsComplete(const std::string& path, const std::vector<char>& bytes);

}  // namespace cosplat
