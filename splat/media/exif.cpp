#include <cstdint>
#include <string_view>
#include <utility>

#include "splat/media/image_io.h"

namespace cosplat {
namespace {

constexpr uint32_t kOrientation = 0x0112, kExifFolder = 0x8769, kFocalLength = 0x920a;
constexpr uint32_t kExtraSamples = 0x0152;
// Tags of raw files (TIFF/EP, DNG): what the first image is, where the others are, DNG's version.
constexpr uint32_t kSubfileType = 0x00fe, kSubfolders = 0x014a, kDngVersion = 0xc612;

// The TIFF structure that EXIF consists of: folders of 12-byte entries, in either byte order. What
// lies outside reads as zero.
class Tiff {
 public:
  Tiff(const char* data, size_t size)
      : data_(data), size_(size), little_(size > 0 && data[0] == 'I') {}

  uint32_t Read(size_t at, size_t count) const {
    if (at > size_ || count > size_ - at) return 0;
    uint32_t value = 0;
    for (size_t i = 0; i < count; ++i)
      value = value << 8 | uint8_t(data_[little_ ? at + count - 1 - i : at + i]);
    return value;
  }

  // Where the value of an entry is stored; 0 if the folder does not have it.
  size_t Find(size_t folder, uint32_t tag) const {
    const uint32_t entries = folder == 0 ? 0 : Read(folder, 2);
    for (size_t i = 0; i < entries && folder + 2 + 12 * i < size_; ++i)
      if (Read(folder + 2 + 12 * i, 2) == tag) return folder + 2 + 12 * i + 8;
    return 0;
  }

 private:
  const char* data_;
  size_t size_;
  bool little_;
};

ExifInfo ParseTiff(const Tiff& tiff) {
  ExifInfo info;
  const size_t first = tiff.Read(4, 4);
  if (const size_t at = tiff.Find(first, kOrientation)) {
    const int orientation = int(tiff.Read(at, 2));
    if (orientation >= 1 && orientation <= 8) {
      info.orientation = orientation;
      info.orientation_at = at;
    }
  }
  const size_t type = tiff.Find(first, kSubfileType);
  info.is_raw = tiff.Find(first, kDngVersion) != 0 ||
                (type != 0 && tiff.Read(type, 4) == 1 && tiff.Find(first, kSubfolders) != 0);
  if (const size_t at = tiff.Find(first, kExtraSamples)) info.extra_samples = int(tiff.Read(at, 2));
  if (const size_t at = tiff.Find(first, kExifFolder))
    if (const size_t focal = tiff.Find(tiff.Read(at, 4), kFocalLength)) {
      const size_t ratio = tiff.Read(focal, 4);
      const double divisor = tiff.Read(ratio + 4, 4);
      if (ratio > 0 && divisor > 0) info.focal_length = tiff.Read(ratio, 4) / divisor;
    }
  return info;
}

// The TIFF structure in a JPEG's segments before the pixels: a marker of two bytes, then the size
// that counts itself.
std::string_view InJpeg(std::string_view bytes) {
  constexpr std::string_view kName("Exif\0\0", 6);
  for (size_t at = 2; at + 4 <= bytes.size() && uint8_t(bytes[at]) == 0xff;) {
    const uint8_t marker = uint8_t(bytes[at + 1]);
    const size_t size = size_t(uint8_t(bytes[at + 2])) << 8 | uint8_t(bytes[at + 3]);
    if (marker == 0xda || size < 2 || size > bytes.size() - at - 2) break;
    const std::string_view content = bytes.substr(at + 4, size - 2);
    if (marker == 0xe1 && content.size() > 8 && content.starts_with(kName))
      return content.substr(kName.size());
    at += 2 + size;
  }
  return {};
}

// In a file of chunks that have a name of four letters and a size of four bytes, the size first
// (PNG, whose chunks end in a checksum) or last and lowest byte first (WebP, at even places).
std::string_view InChunks(std::string_view bytes, size_t first, std::string_view name, bool png) {
  for (size_t at = first; at + 8 <= bytes.size();) {
    size_t size = 0;
    for (size_t i = 0; i < 4; ++i)
      size |= size_t(uint8_t(bytes[png ? at + 3 - i : at + 4 + i])) << 8 * i;
    if (size > bytes.size() - at - 8) break;
    if (bytes.substr(png ? at + 4 : at, 4) == name) return bytes.substr(at + 8, size);
    at += 8 + size + (png ? 4 : size % 2);
  }
  return {};
}

std::string_view TiffIn(std::string_view bytes) {
  if (bytes.starts_with("\xff\xd8")) return InJpeg(bytes);
  if (bytes.starts_with("\x89PNG")) return InChunks(bytes, 8, "eXIf", true);
  if (bytes.starts_with("RIFF") && bytes.substr(0, 12).ends_with("WEBP")) {
    const std::string_view exif = InChunks(bytes, 12, "EXIF", false);
    return exif.starts_with("Exif") && exif.size() > 6 ? exif.substr(6) : exif;
  }
  if (bytes.starts_with("II*") || bytes.starts_with("MM")) return bytes;
  return {};
}

}  // namespace

ExifInfo ParseExif(const std::vector<char>& bytes) {
  const std::string_view tiff = TiffIn({bytes.data(), bytes.size()});
  if (tiff.size() < 8) return {};
  ExifInfo info = ParseTiff(Tiff(tiff.data(), tiff.size()));
  if (tiff.data() == bytes.data()) return info;
  return {info.orientation, info.focal_length};  // the rest is of TIFF files themselves
}

Image8 Upright(const Image8& image, int orientation) {
  if (orientation == 1) return image;
  const bool swaps = orientation >= 5;
  const bool flips_x = orientation == 2 || orientation == 3 || orientation >= 7;
  const bool flips_y = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  Image8 result(
      swaps ? image.height : image.width, swaps ? image.width : image.height, image.channels);
  for (int y = 0; y < result.height; ++y)
    for (int x = 0; x < result.width; ++x) {
      int from_x = swaps ? y : x, from_y = swaps ? x : y;
      if (flips_x) from_x = image.width - 1 - from_x;
      if (flips_y) from_y = image.height - 1 - from_y;
      for (int c = 0; c < image.channels; ++c) result.at(x, y, c) = image.at(from_x, from_y, c);
    }
  return result;
}

}  // namespace cosplat
