// Image and video files. image_io.cpp and video_io.cpp are the only places of the libraries that
// include OpenCV for pixels.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"

namespace cosplat {

// Width and height in pixels and number of channels (1, 3 or 4) of an image file.
struct ImageInfo {
  int width = 0;
  int height = 0;
  int channels = 0;
};

// From the header alone where the file is PNG or JPEG; throws Error as ReadImage does.
ImageInfo ReadImageInfo(const std::string& path);

// Reads PNG, JPEG, ... as RGB (3) or RGBA (4) or grey (1), 8 bits; 16-bit files are scaled down.
// EXIF orientation is ignored, as COLMAP does. Throws Error when the file is missing, broken or cut
// off (decoders would return a partial image).
Image8 ReadImage(const std::string& path);

// The bytes of a PNG or JPEG file, by the extension of `path`, which is otherwise for errors; 1, 3
// or 4 channels (JPEG: not 4).
std::vector<uint8_t> EncodeImage(const std::string& path, const Image8& image);

// Writes them through a temporary file.
void WriteImage(const std::string& path, const Image8& image);
void WriteImage(const std::string& path, const Image& image);  // clamped to [0, 1], rounded

// Clamped to [0, 1] and rounded; throws Error naming the pixel when one is not a number.
Image8 ToBytes(const Image& image);
Image ToFloat(const Image8& image);

// Mean over the covered source area (cv::INTER_AREA); width and height >= 1. Colour is weighted by
// alpha where there is a fourth channel, so that a background under alpha 0 does not bleed in.
Image8 ResizeByArea(const Image8& image, int width, int height);

// Removes lens distortion: resamples `image` (bilinear, alpha-weighted; edge pixels repeat outside)
// as if taken by the pinhole `target` of the same pose.
// `model`: kBrown {k1,k2,p1,p2,k3,k4,k5,k6} (OpenCV's order) or kFisheye {k1,k2,k3,k4}.
struct Distortion {
  enum class Model { kNone, kBrown, kFisheye } model = Model::kNone;
  double k[8] = {0, 0, 0, 0, 0, 0, 0, 0};
};
Image8 Undistort(const Image8& image,
                 const Camera& source,
                 const Distortion& distortion,
                 const Camera& target);

// Where the pinhole rays through `points` (px in `target`) meet the distorted image `source`, px.
std::vector<std::array<double, 2>> DistortedPixels(
    const Camera& source,
    const Distortion& distortion,
    const Camera& target,
    const std::vector<std::array<double, 2>>& points);

// Frames of a video file, decoded in order. May be called from several threads, one at a time.
class VideoReader {
 public:
  explicit VideoReader(const std::string& path);  // throws Error
  ~VideoReader();
  int frame_count() const;
  // RGB; cheap for index = last + 1, an earlier one decodes from the start again. Throws Error.
  Image8 ReadFrame(int index);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// MP4 (mp4v) writer; the file appears under its name when Finish() succeeds.
class VideoWriter {
 public:
  VideoWriter(const std::string& path, int width, int height, double frames_per_second);
  ~VideoWriter();
  void Write(const Image8& rgb);
  void Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// What a PNG or JPEG file says about itself, without decoding it. Decoders hand back partial
// images for cut-off files; walking the file's own structure finds the cut.

// True and `info` filled when `bytes` (a whole file or its beginning) is a PNG or JPEG with a
// complete header.
bool ParseImageHeader(const std::vector<char>& bytes, ImageInfo& info);

// Throws Error(path, ...) when a PNG lacks chunks up to IEND or one of its critical chunks fails
// its CRC, or when a JPEG lacks its end-of-image marker. Other kinds of file pass.
void CheckImageIsComplete(const std::string& path, const std::vector<char>& bytes);

// Keeps OpenCV and FFmpeg from writing to stderr: failures are reported as Error instead.

// Called before any of their functions; only the first call does anything.
void QuietOpenCv();

}  // namespace cosplat
