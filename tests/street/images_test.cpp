// Masks and images in the forms in which people have them.
#include <gtest/gtest.h>

#include <algorithm>

#include "splat/media/image_io.h"
#include "tests/street/nerf_scene.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

// The middle is what the mask shows.
bool InMiddle(int x, int y) { return x >= 4 && x < 12 && y >= 4 && y < 12; }

template <class Pixel>
Image8 Mask(int channels, const Pixel& pixel) {
  Image8 mask(16, 16, channels);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x)
      for (int c = 0; c < channels; ++c) mask.at(x, y, c) = uint8_t(pixel(InMiddle(x, y), c, x));
  return mask;
}

void ExpectMiddle(const Image8& mask, const char* what) {
  const Image8 matte = MatteOf(mask);
  ASSERT_EQ(matte.channels, 1) << what;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x)
      ASSERT_EQ(matte.at(x, y, 0), InMiddle(x, y) ? 255 : 0) << what << " " << x << " " << y;
}

TEST(Masks, MeanWhatTheyMean) {
  ExpectMiddle(Mask(1, [](bool in, int, int) { return in ? 255 : 0; }), "0 and 255");
  ExpectMiddle(Mask(1, [](bool in, int, int) { return in ? 1 : 0; }), "0 and 1");
  ExpectMiddle(Mask(1, [](bool in, int, int x) { return in ? 1 + x % 5 : 0; }), "labels");
  ExpectMiddle(Mask(1, [](bool in, int, int) { return in ? 128 : 0; }), "0 and 128");
  ExpectMiddle(Mask(3, [](bool in, int c, int) { return in && c == 0 ? 255 : 0; }), "red on black");
  ExpectMiddle(Mask(3, [](bool in, int c, int x) { return in && c == x % 3 ? 128 : 0; }),
               "palette");
  ExpectMiddle(Mask(4, [](bool in, int c, int) { return c == 3 ? (in ? 255 : 0) : 200; }), "alpha");
  ExpectMiddle(Mask(4, [](bool in, int c, int) { return c == 3 || in ? 255 : 0; }), "opaque alpha");
  ExpectMiddle(Mask(4, [](bool in, int c, int) { return c == 3 ? (in ? 1 : 0) : 255; }),
               "0 and 1 in alpha");
}

TEST(Masks, SoftEdgesStaySoft) {
  const Image8 soft = Mask(1, [](bool in, int, int x) { return in ? 255 : 5 * x; });
  EXPECT_EQ(MatteOf(soft).data, soft.data);
}

TEST(Images, OpaqueAlphaSaysNothing) {
  EXPECT_FALSE(SaysAlpha(Image8(8, 8, 4, 255)));
  EXPECT_FALSE(SaysAlpha(Image8(8, 8, 3, 0)));
  EXPECT_TRUE(SaysAlpha(Image8(8, 8, 4, 254)));
}

TEST(Images, AreTurnedAsViewersDo) {
  const TemporaryFolder folder;
  const Image8 upright = NerfScene::Photograph(0, 0);
  const int inverse[] = {1, 1, 2, 3, 4, 5, 8, 7, 6};
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const std::string path = folder / "photo.jpg";
    WriteImage(path, Upright(upright, inverse[orientation]));
    SetOrientation(path, orientation);
    const ImageInfo info = ReadImageInfo(path);
    EXPECT_EQ(info.orientation, orientation);
    EXPECT_EQ(info.Upright().width, upright.width);
    const Image8 image = ReadUpright(path);
    ASSERT_EQ(SizeText(image.width, image.height), SizeText(upright.width, upright.height));
    double sum = 0;
    for (size_t i = 0; i < image.data.size(); ++i) sum += std::abs(image.data[i] - upright.data[i]);
    EXPECT_LT(sum / double(image.data.size()), 10) << orientation;
  }
}

// A photograph whose columns differ, or one with a white ground, which a cut one is often filled
// with.
Image8 Columns(bool on_white) {
  Image8 image(96, 64, 3, 255);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 96; ++x)
      for (int c = 0; c < 3; ++c)
        if (!on_white || (x < 60 && y < 40)) image.at(x, y, c) = uint8_t(5 * x + 3 * y + 80 * c);
  return image;
}

// As some phones write them: no end marker, then the maker's own data.
TEST(Images, JpegsWithoutAnEndAreJudgedByTheirPixels) {
  const TemporaryFolder folder;
  const std::string path = folder / "phone.jpg";
  for (const bool on_white : {false, true}) {
    WriteImage(path, Columns(on_white));
    const std::vector<char> jpeg = ReadFile(path);
    const std::string whole(jpeg.begin(), jpeg.end() - 2);
    const Image8 complete = ReadImage(path);
    for (const std::string& trailer : {std::string(), std::string("\0\0SEFT maker's data", 19)}) {
      WriteFileAtomically(path, whole + trailer);
      EXPECT_EQ(ReadImage(path).data, complete.data) << on_white << trailer;
    }
    for (const double part : {0.6, 0.8, 0.9}) {
      WriteFileAtomically(path, whole.substr(0, size_t(double(whole.size()) * part)));
      ExpectError([&] { ReadImage(path); }, {"phone.jpg", "truncated"});
    }
  }
}

TEST(Images, OfOtherKindsAreNamed) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& bytes, const char* what) {
    WriteFileAtomically(folder / "photo.jpg", bytes);
    ExpectError([&] { ReadImage(folder / "photo.jpg"); }, {"photo.jpg", what});
  };
  expect(std::string("\0\0\0\x18"
                     "ftypheic\0\0\0\0mif1heic",
                     24),
         "HEIC");
  expect(std::string("\0\0\0\x1c"
                     "ftypavif\0\0\0\0avifmif1",
                     24),
         "AVIF");
  expect("version https://git-lfs.github.com/spec/v1\n", "git lfs pull");
  expect("<html><body>Not found</body></html>", "web page");
  expect("404: Not Found", "web page");
  expect("\xef\xbb\xbfversion https://git-lfs.github.com/spec/v1\r\n", "git lfs pull");
  expect(std::string("\0\0\0\x18"
                     "ftypcrx \0\0\0\1crx isom",
                     24),
         "raw image");
}

struct TiffEntry {
  uint32_t tag, type, value;
};

// A TIFF of 8 x 8 pixels in one strip, without compression. `more`: further entries.
std::string Tiff(uint32_t channels,
                 uint32_t bits,
                 const std::string& pixels,
                 const std::vector<TiffEntry>& more) {
  const auto n = [](uint32_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += char(value >> 8 * i & 255);
    return text;
  };
  const uint32_t count = uint32_t(10 + more.size()), data = 8 + 2 + 12 * count + 4;
  std::vector<TiffEntry> entries = {{256, 3, 8},
                                    {257, 3, 8},
                                    {258, 3, channels == 1 ? bits : data},
                                    {259, 3, 1},
                                    {262, 3, channels == 1 ? 1u : 2u},
                                    {273, 4, data + 8},
                                    {277, 3, channels},
                                    {278, 3, 8},
                                    {279, 4, uint32_t(pixels.size())},
                                    {284, 3, 1}};
  entries.insert(entries.end(), more.begin(), more.end());
  std::sort(entries.begin(), entries.end(), [](const TiffEntry& a, const TiffEntry& b) {
    return a.tag < b.tag;
  });
  std::string tiff = "II" + n(42, 2) + n(8, 4) + n(count, 2);
  for (const TiffEntry& e : entries)
    tiff += n(e.tag, 2) + n(e.type, 2) + n(e.tag == 258 ? channels : 1, 4) + n(e.value, 4);
  tiff += n(0, 4);
  for (int c = 0; c < 4; ++c) tiff += n(bits, 2);
  return tiff + pixels;
}

// OpenCV turns TIFFs by itself: once is enough.
TEST(Images, TiffsAreTurnedOnce) {
  const TemporaryFolder folder;
  // Where the corner that is stored first goes: right, bottom.
  const bool corner[8][2] = {{false, false},
                             {true, false},
                             {true, true},
                             {false, true},
                             {false, false},
                             {true, false},
                             {true, true},
                             {false, true}};
  std::string pixels(64, '\x14');
  pixels[0] = '\xfa', pixels[1] = '\x96';  // the second tells turns from mirrors
  const std::string path = folder / "photo.tif";
  for (uint32_t orientation = 1; orientation <= 8; ++orientation) {
    WriteFileAtomically(path, Tiff(1, 8, pixels, {{274, 3, orientation}}));
    EXPECT_EQ(ReadImage(path).at(0, 0, 0), 0xfa) << orientation;  // as it is stored
    const Image8 upright = ReadUpright(path);
    const auto [right, bottom] = corner[orientation - 1];
    const int x = right ? 7 : 0, y = bottom ? 7 : 0;
    EXPECT_EQ(upright.at(x, y, 0), 0xfa) << orientation;
    const bool on_side = orientation >= 5;
    EXPECT_EQ(upright.at(on_side ? x : std::abs(x - 1), on_side ? std::abs(y - 1) : y, 0), 0x96)
        << orientation;
  }
}

TEST(Masks, LabelsOf16BitsAreLabels) {
  const TemporaryFolder folder;
  const std::string path = folder / "mask.tif";
  for (const char label : {'\x01', '\x64'}) {
    std::string pixels;
    for (int i = 0; i < 64; ++i) pixels += {i % 8 < 4 ? label : '\0', '\0'};
    WriteFileAtomically(path, Tiff(1, 16, pixels, {}));
    const Image8 matte = MatteOf(ReadImage(path));
    EXPECT_EQ(matte.at(0, 0, 0), 255) << int(label);
    EXPECT_EQ(matte.at(7, 0, 0), 0) << int(label);
  }
}

// Their first image is a small preview.
TEST(Images, RawTiffsAreNamed) {
  const TemporaryFolder folder;
  const std::string pixels(64, '\x50');
  for (const std::vector<TiffEntry>& more : {std::vector<TiffEntry>{{50706, 1, 0x401}},
                                             std::vector<TiffEntry>{{254, 4, 1}, {330, 4, 8}}}) {
    WriteFileAtomically(folder / "photo.tif", Tiff(1, 8, pixels, more));
    ExpectError([&] { ReadImage(folder / "photo.tif"); }, {"photo.tif", "raw image"});
  }
}

TEST(Images, TiffsAlphaIsStraight) {
  const TemporaryFolder folder;
  for (const uint32_t extra : {1u, 2u}) {
    const int scale = extra == 1 ? 2 : 1;
    std::string pixels;
    for (int i = 0; i < 64; ++i)
      pixels += {char(200 / scale), char(100 / scale), char(40), char(128)};
    WriteFileAtomically(folder / "cut.tif", Tiff(4, 8, pixels, {{338, 3, extra}}));
    const Image8 image = ReadImage(folder / "cut.tif");
    ASSERT_EQ(image.channels, 4);
    EXPECT_NEAR(image.data[0], 200, 3) << extra;
    EXPECT_NEAR(image.data[1], 100, 3) << extra;
    EXPECT_EQ(image.data[3], 128) << extra;
  }
}

}  // namespace
}  // namespace cosplat::test
