// PNG and JPEG in the browser, by stb; what the other image_io.cpp has besides needs OpenCV.
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

constexpr const char* kNotInBrowser = "cannot be read in a browser";

Image8 Decode(const std::string& path, const std::vector<char>& bytes) {
  CheckImageIsComplete(path, bytes);
  Image8 image;
  const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> pixels(
      stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()),
                            int(bytes.size()),
                            &image.width,
                            &image.height,
                            &image.channels,
                            0),
      stbi_image_free);
  if (!pixels || image.channels == 2) throw Error(path, "cannot be decoded as an image");
  image.data.assign(pixels.get(), pixels.get() + image.pixels() * size_t(image.channels));
  return image;
}

// Colour times alpha, so that averages weight colour by coverage.
std::vector<float> Premultiplied(const Image8& image) {
  std::vector<float> values(image.data.begin(), image.data.end());
  for (size_t i = 0; image.channels == 4 && i < image.pixels(); ++i)
    for (size_t c = 0; c < 3; ++c) values[4 * i + c] *= values[4 * i + 3] / 255;
  return values;
}

// What part of which pixels of a row of `from` each of `to` covers.
struct Cover {
  int first;
  std::vector<float> weights;  // of `first` and those after it; their sum is 1
};
std::vector<Cover> CoversOf(int from, int to) {
  std::vector<Cover> covers;
  const double scale = double(from) / to;
  for (int i = 0; i < to; ++i) {
    const double begin = i * scale, end = std::min((i + 1) * scale, double(from));
    Cover cover{int(begin), {}};
    for (int k = cover.first; k < end; ++k)
      cover.weights.push_back(float((std::min(k + 1.0, end) - std::max(double(k), begin)) / scale));
    covers.push_back(std::move(cover));
  }
  return covers;
}

}  // namespace

ImageInfo ReadImageInfo(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  ImageInfo info;
  if (!ParseImageHeader(bytes, info)) throw Error(path, "cannot be decoded as an image");
  info.orientation = ParseExif(bytes).orientation;
  return info;
}

Image8 ReadImage(const std::string& path) { return Decode(path, ReadFile(path)); }

Image8 ReadUpright(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return Upright(Decode(path, bytes), ParseExif(bytes).orientation);
}

std::vector<uint8_t> EncodeImage(const std::string& path, const Image8& image) {
  constexpr int kJpegQuality = 95;
  const bool jpeg = path.ends_with(".jpg");
  if (image.empty() || image.channels == 2 || (!jpeg && !path.ends_with(".png")))
    throw Error(path, "cannot store such an image");
  std::vector<uint8_t> bytes;
  const auto append = [](void* to, void* data, int size) {
    auto& all = *static_cast<std::vector<uint8_t>*>(to);
    all.insert(all.end(), static_cast<uint8_t*>(data), static_cast<uint8_t*>(data) + size);
  };
  const int w = image.width, h = image.height, n = image.channels;
  const int done =
      jpeg ? stbi_write_jpg_to_func(append, &bytes, w, h, n, image.data.data(), kJpegQuality)
           : stbi_write_png_to_func(append, &bytes, w, h, n, image.data.data(), w * n);
  if (done == 0) throw Error(path, "image could not be encoded");
  return bytes;
}

Image8 ResizeByArea(const Image8& image, int width, int height) {
  if (width == image.width && height == image.height) return image;
  if (width < 1 || height < 1 || image.empty())
    throw Error("image", "cannot be resized to " + SizeText(width, height));
  const std::vector<float> values = Premultiplied(image);
  const std::vector<Cover> columns = CoversOf(image.width, width),
                           rows = CoversOf(image.height, height);
  const size_t n = size_t(image.channels);
  Image8 out(width, height, image.channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float sums[4] = {};
      const Cover &row = rows[size_t(y)], &column = columns[size_t(x)];
      for (size_t r = 0; r < row.weights.size(); ++r)
        for (size_t k = 0; k < column.weights.size(); ++k) {
          const size_t at =
              (size_t(row.first) + r) * size_t(image.width) + size_t(column.first) + k;
          for (size_t c = 0; c < n; ++c)
            sums[c] += row.weights[r] * column.weights[k] * values[n * at + c];
        }
      for (size_t c = 0; c < n; ++c) {
        const float whole = n == 4 && c < 3 ? (sums[3] > 0 ? sums[c] * 255 / sums[3] : 0) : sums[c];
        out.at(x, y, int(c)) = uint8_t(std::nearbyint(std::clamp(whole, 0.f, 255.f)));
      }
    }
  return out;
}

Image8 Undistort(const Image8&, const Camera&, const Distortion&, const Camera&) {
  throw Error("a lens's distortion", kNotInBrowser);
}

// The page has the browser's own decoder, and hands in frames.
struct VideoReader::Impl {};
VideoReader::VideoReader(const std::string& path) { throw Error(path, kNotInBrowser); }
VideoReader::~VideoReader() = default;
int VideoReader::frame_count() const { return 0; }
double VideoReader::frames_per_second() const { return 0; }
bool VideoReader::has_alpha() const { return false; }
const std::vector<std::string>& VideoReader::notes() const {
  static const std::vector<std::string> none;
  return none;
}
const std::vector<int>& VideoReader::cuts() const {
  static const std::vector<int> none;
  return none;
}
Image8 VideoReader::ReadFrame(int) { return {}; }

struct VideoWriter::Impl {};
VideoWriter::VideoWriter(const std::string& path, int, int, double, std::optional<Sound>) {
  throw Error(path, "cannot be written in a browser");
}
VideoWriter::~VideoWriter() = default;
void VideoWriter::Write(const Image8&) {}
void VideoWriter::Finish() {}

}  // namespace cosplat
