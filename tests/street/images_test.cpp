// Masks and images in the forms in which people have them.
#include <gtest/gtest.h>

#include "splat/base/exif.h"
#include "splat/base/matte.h"
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

// As some phones write them: no end marker, then the maker's own data.
TEST(Images, JpegsWithoutAnEndAreJudgedByTheirPixels) {
  const TemporaryFolder folder;
  const std::string path = folder / "phone.jpg";
  WriteImage(path, NerfScene::Photograph(0, 0));
  const std::vector<char> jpeg = ReadFile(path);
  const std::string whole(jpeg.begin(), jpeg.end() - 2);
  WriteFileAtomically(path, whole + std::string("\0\0SEFT maker's data", 19));
  EXPECT_EQ(ReadImage(path).width, NerfScene::kWidth);
  WriteFileAtomically(path, whole.substr(0, whole.size() * 6 / 10));
  ExpectError([&] { ReadImage(path); }, {"phone.jpg", "truncated"});
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
}

// A TIFF of one strip, 8 bits, RGBA; extra: 1 for colours that are multiplied by alpha, 2 for
// straight.
std::string Tiff(int extra, const std::array<uint8_t, 4>& pixel) {
  const auto n = [](uint32_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += char(value >> 8 * i & 255);
    return text;
  };
  constexpr uint32_t kSide = 8, kEntries = 11, kData = 8 + 2 + 12 * kEntries + 4;
  std::string tiff = "II" + n(42, 2) + n(8, 4) + n(kEntries, 2);
  const auto entry = [&](uint32_t tag, uint32_t type, uint32_t count, uint32_t value) {
    tiff += n(tag, 2) + n(type, 2) + n(count, 4) + n(value, 4);
  };
  entry(256, 3, 1, kSide);
  entry(257, 3, 1, kSide);
  entry(258, 3, 4, kData);
  entry(259, 3, 1, 1);
  entry(262, 3, 1, 2);
  entry(273, 4, 1, kData + 8);
  entry(277, 3, 1, 4);
  entry(278, 3, 1, kSide);
  entry(279, 4, 1, 4 * kSide * kSide);
  entry(284, 3, 1, 1);
  entry(338, 3, 1, uint32_t(extra));
  tiff += n(0, 4);
  for (int c = 0; c < 4; ++c) tiff += n(8, 2);
  for (uint32_t i = 0; i < kSide * kSide; ++i) tiff.append(pixel.begin(), pixel.end());
  return tiff;
}

TEST(Images, TiffsAlphaIsStraight) {
  const TemporaryFolder folder;
  for (const int extra : {1, 2}) {
    const uint8_t scale = extra == 1 ? 2 : 1;
    WriteFileAtomically(folder / "cut.tif",
                        Tiff(extra, {uint8_t(200 / scale), uint8_t(100 / scale), 40, 128}));
    const Image8 image = ReadImage(folder / "cut.tif");
    ASSERT_EQ(image.channels, 4);
    EXPECT_NEAR(image.data[0], 200, 3) << extra;
    EXPECT_NEAR(image.data[1], 100, 3) << extra;
    EXPECT_EQ(image.data[3], 128) << extra;
  }
}

}  // namespace
}  // namespace cosplat::test
