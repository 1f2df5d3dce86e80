// What a camera wrote into a JPEG: orientation and focal length.
#include <gtest/gtest.h>

#include <string>

#include "splat/media/image_io.h"

namespace cosplat {
namespace {

std::string Number(uint32_t value, int bytes, bool little) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += char(value >> 8 * (little ? i : bytes - 1 - i) & 255);
  return text;
}

// The beginning of a JPEG with these two values.
std::vector<char> JpegWithExif(int orientation, int focal_tenths, bool little) {
  const auto n = [&](uint32_t value, int bytes) { return Number(value, bytes, little); };
  const auto entry = [&](int tag, int type, const std::string& value) {
    return n(tag, 2) + n(type, 2) + n(1, 4) + value;
  };
  std::string tiff = (little ? "II" : "MM") + n(42, 2) + n(8, 4);
  tiff += n(2, 2) + entry(0x0112, 3, n(orientation, 2) + n(0, 2)) + entry(0x8769, 4, n(38, 4));
  tiff += n(0, 4);                                         // at 34: no further folder
  tiff += n(1, 2) + entry(0x920a, 5, n(56, 4)) + n(0, 4);  // at 38
  tiff += n(uint32_t(focal_tenths), 4) + n(10, 4);         // at 56
  const std::string exif = std::string("Exif\0\0", 6) + tiff;
  const std::string jfif = "JFIF padding";
  std::string bytes = "\xff\xd8\xff\xe0" + Number(uint32_t(jfif.size() + 2), 2, false) + jfif;
  bytes += "\xff\xe1" + Number(uint32_t(exif.size() + 2), 2, false) + exif + "\xff\xda";
  return {bytes.begin(), bytes.end()};
}

TEST(Exif, ReadsBothByteOrders) {
  for (const bool little : {true, false}) {
    const ExifInfo info = ParseExif(JpegWithExif(6, 42, little));
    EXPECT_EQ(info.orientation, 6);
    EXPECT_DOUBLE_EQ(info.focal_length, 4.2);
  }
}

TEST(Exif, DefaultsWithoutIt) {
  EXPECT_EQ(ParseExif({}).orientation, 1);
  EXPECT_EQ(ParseExif({'\x89', 'P', 'N', 'G'}).focal_length, 0);
  EXPECT_EQ(ParseExif(JpegWithExif(9, 0, true)).orientation, 1);
}

TEST(Exif, DamagedOnesAreRead) {
  const std::vector<char> whole = JpegWithExif(3, 50, true);
  for (size_t size = 0; size < whole.size(); ++size)
    ParseExif({whole.begin(), whole.begin() + std::ptrdiff_t(size)});
  for (size_t i = 0; i < whole.size(); ++i)
    for (const int value : {0, 0x7f, 0xff}) {
      std::vector<char> damaged = whole;
      damaged[i] = char(value);
      const ExifInfo info = ParseExif(damaged);
      EXPECT_GE(info.orientation, 1);
      EXPECT_LE(info.orientation, 8);
    }
}

// A 3x2 image of its pixels' numbers; what each orientation shows (EXIF 2.3, table of Orientation).
TEST(Exif, UprightAsTheStandardSays) {
  Image8 stored(3, 2, 1);
  for (int i = 0; i < 6; ++i) stored.data[i] = uint8_t(i);
  const std::vector<std::vector<uint8_t>> shown{{0, 1, 2, 3, 4, 5},
                                                {2, 1, 0, 5, 4, 3},
                                                {5, 4, 3, 2, 1, 0},
                                                {3, 4, 5, 0, 1, 2},
                                                {0, 3, 1, 4, 2, 5},
                                                {3, 0, 4, 1, 5, 2},
                                                {5, 2, 4, 1, 3, 0},
                                                {2, 5, 1, 4, 0, 3}};
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const Image8 image = Upright(stored, orientation);
    EXPECT_EQ(image.width, orientation < 5 ? 3 : 2);
    EXPECT_EQ(image.data, shown[orientation - 1]) << "orientation " << orientation;
  }
}

}  // namespace
}  // namespace cosplat
