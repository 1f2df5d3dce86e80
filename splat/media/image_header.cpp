#include <cstdint>
#include <cstring>
#include <functional>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

uint32_t BigEndian(const char* p, int count) {
  uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | uint8_t(p[i]);
  return value;
}

bool IsPng(const std::vector<char>& bytes) {
  return bytes.size() >= 8 && std::memcmp(bytes.data(), "\x89PNG\r\n\x1a\n", 8) == 0;
}

bool IsJpeg(const std::vector<char>& bytes) {
  return bytes.size() >= 3 && std::memcmp(bytes.data(), "\xff\xd8\xff", 3) == 0;
}

bool ParsePngHeader(const std::vector<char>& bytes, ImageInfo& info) {
  if (bytes.size() < 33 || std::memcmp(bytes.data() + 12, "IHDR", 4) != 0) return false;
  info.width = int(BigEndian(bytes.data() + 16, 4));
  info.height = int(BigEndian(bytes.data() + 20, 4));
  const int color_type = bytes[25];
  info.channels = color_type == 0 ? 1 : color_type == 2 || color_type == 3 ? 3 : 4;
  // Palette transparency or a colour key, stored before the pixels, adds a fourth channel.
  for (size_t at = 33; bytes.size() - at >= 8;) {
    const size_t size = BigEndian(bytes.data() + at, 4);
    const char* type = bytes.data() + at + 4;
    if (std::memcmp(type, "IDAT", 4) == 0) return true;
    if (std::memcmp(type, "tRNS", 4) == 0 && color_type != 0) info.channels = 4;
    if (bytes.size() - at < 12 + size) return false;
    at += 12 + size;
  }
  return false;
}

void CheckPng(const std::string& path, const std::vector<char>& bytes) {
  for (size_t at = 8; bytes.size() - at >= 12;) {
    const size_t size = BigEndian(bytes.data() + at, 4);
    const char* type = bytes.data() + at + 4;
    if (bytes.size() - at - 12 < size) break;
    const bool critical = (type[0] & 0x20) == 0;
    if (critical && Crc32(type, size + 4) != BigEndian(type + 4 + size, 4))
      throw Error(path, "is damaged: checksum of chunk " + std::string(type, 4) + " is wrong");
    if (std::memcmp(type, "IEND", 4) == 0) return;
    at += 12 + size;
  }
  throw Error(path, "is truncated after " + std::to_string(bytes.size()) + " bytes");
}

bool HasLength(uint8_t marker) {
  return marker != 0x01 && marker != 0xd8 && !(marker >= 0xd0 && marker <= 0xd7);
}

// Calls `visit(marker, data, size)` for every marker of a JPEG, skipping entropy-coded data, until
// it returns false. Returns whether `visit` returned false.
using MarkerVisitor = std::function<bool(uint8_t marker, const char* data, size_t size)>;
bool WalkJpeg(const std::vector<char>& bytes, const MarkerVisitor& visit) {
  size_t at = 2;
  while (at + 1 < bytes.size()) {
    const uint8_t marker = uint8_t(bytes[at + 1]);
    // Not a marker: entropy-coded data, a stuffed zero, or a fill byte.
    if (uint8_t(bytes[at]) != 0xff || marker == 0x00 || marker == 0xff) {
      ++at;
      continue;
    }
    at += 2;
    if (marker == 0xd9) return !visit(marker, nullptr, 0);
    if (!HasLength(marker)) continue;
    if (bytes.size() - at < 2) return false;
    const size_t size = BigEndian(bytes.data() + at, 2);
    if (size < 2 || bytes.size() - at < size) return false;
    if (!visit(marker, bytes.data() + at + 2, size - 2)) return true;
    at += size;
  }
  return false;
}

bool ParseJpegHeader(const std::vector<char>& bytes, ImageInfo& info) {
  bool found = false;
  WalkJpeg(bytes, [&](uint8_t marker, const char* data, size_t size) {
    // Start of frame: C0-CF except for tables and arithmetic conditioning.
    const bool frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (!frame || size < 6) return true;
    info.height = int(BigEndian(data + 1, 2));
    info.width = int(BigEndian(data + 3, 2));
    info.channels = data[5] == 1 ? 1 : 3;
    found = true;
    return false;
  });
  return found;
}

// An image of a few bytes that would take gigabytes: as no honest encoder writes it.
void CheckImageSize(const std::string& path, const std::vector<char>& bytes) {
  constexpr int64_t kMaxPixels = int64_t(1) << 28;  // 16,384 x 16,384
  // Deflate packs 1032 bytes into one, PNG 8 pixels into a byte. JPEG takes at least a bit for each
  // block of 64 pixels.
  constexpr int64_t kPngPixelsPerByte = 8 * 1032, kJpegPixelsPerByte = 8 * 64;
  ImageInfo info;
  if (!ParseImageHeader(bytes, info)) return;
  const int64_t pixels = int64_t(info.width) * info.height;
  if (info.width < 1 || info.height < 1 || pixels > kMaxPixels)
    throw Error(path,
                "has " + SizeText(info.width, info.height) + " pixels, expected 1 to " +
                    std::to_string(kMaxPixels));
  if (pixels > int64_t(bytes.size()) * (IsPng(bytes) ? kPngPixelsPerByte : kJpegPixelsPerByte))
    throw Error(path,
                "is damaged: " + std::to_string(bytes.size()) + " bytes cannot be an image of " +
                    SizeText(info.width, info.height) + " pixels");
}

bool HasJpegEnd(const std::vector<char>& bytes) {
  return WalkJpeg(bytes, [](uint8_t marker, const char*, size_t) { return marker != 0xd9; });
}

}  // namespace

bool ParseImageHeader(const std::vector<char>& bytes, ImageInfo& info) {
  if (IsPng(bytes)) return ParsePngHeader(bytes, info);
  if (IsJpeg(bytes)) return ParseJpegHeader(bytes, info);
  return false;
}

void CheckImageIsComplete(const std::string& path, const std::vector<char>& bytes) {
  if (bytes.empty()) throw Error(path, "is empty, expected an image");
  CheckImageSize(path, bytes);
  if (IsPng(bytes)) CheckPng(path, bytes);
  if (IsJpeg(bytes) && !HasJpegEnd(bytes) && !LacksJpegEnd(bytes))
    throw Error(path, "is truncated after " + std::to_string(bytes.size()) + " bytes");
}

bool LacksJpegEnd(const std::vector<char>& bytes) {
  bool baseline = false, has_pixels = false;
  if (!IsJpeg(bytes) || HasJpegEnd(bytes)) return false;
  WalkJpeg(bytes, [&](uint8_t marker, const char*, size_t) {
    baseline = baseline || marker == 0xc0 || marker == 0xc1;
    has_pixels = marker == 0xda;
    return !has_pixels;
  });
  return baseline && has_pixels;
}

}  // namespace cosplat
