// Masks and images in the forms in which people have them.
#include <gtest/gtest.h>

#include "splat/base/exif.h"
#include "splat/base/matte.h"
#include "tests/street/nerf_scene.h"

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

}  // namespace
}  // namespace cosplat::test
