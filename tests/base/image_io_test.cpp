#include "splat/media/image_io.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "splat/base/files.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

Image8 Gradient(int width, int height, int channels) {
  Image8 image(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c)
        image.at(x, y, c) = uint8_t((c + 1) * 40 + 100 * x / width + 30 * y / height);
  return image;
}

std::string Bytes(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

TEST(ImageIo, PngKeepsEveryChannelCount) {
  const TemporaryFolder folder;
  for (int channels : {1, 3, 4}) {
    const Image8 image = Gradient(7, 5, channels);
    WriteImage(folder / "a.png", image);
    const Image8 read = ReadImage(folder / "a.png");
    EXPECT_EQ(read.channels, channels);
    EXPECT_EQ(read.data, image.data);
    const ImageInfo info = ReadImageInfo(folder / "a.png");
    EXPECT_EQ(info.width, 7);
    EXPECT_EQ(info.height, 5);
    EXPECT_EQ(info.channels, channels);
  }
}

TEST(ImageIo, JpegIsCloseAndRgb) {
  const TemporaryFolder folder;
  const Image8 image = Gradient(32, 24, 3);
  WriteImage(folder / "a.jpg", image);
  const Image8 read = ReadImage(folder / "a.jpg");
  ASSERT_EQ(read.data.size(), image.data.size());
  for (size_t i = 0; i < image.data.size(); ++i) EXPECT_NEAR(read.data[i], image.data[i], 6);
  const ImageInfo info = ReadImageInfo(folder / "a.jpg");
  EXPECT_EQ(info.width, 32);
  EXPECT_EQ(info.height, 24);
  EXPECT_EQ(info.channels, 3);
}

// Decoders fill the missing part with grey and say nothing: every cut must be found.
TEST(ImageIo, CutOffImagesAreErrors) {
  const TemporaryFolder folder;
  for (const char* extension : {".png", ".jpg"}) {
    const std::string name = folder / ("whole" + std::string(extension));
    WriteImage(name, Gradient(40, 30, 3));
    const std::string whole = Bytes(name);
    const std::string cut_name = folder / ("cut" + std::string(extension));
    for (size_t cut = 0; cut < whole.size(); cut += cut < 60 ? 1 : 7) {
      if (cut + 2 >= whole.size()) break;
      WriteFileAtomically(cut_name, whole.substr(0, cut));
      ExpectError([&] { ReadImage(cut_name); }, {cut_name});
    }
    // A JPEG that lacks its end marker alone has all its pixels.
    const size_t lost = extension == std::string(".jpg") ? 4 : 1;
    WriteFileAtomically(cut_name, whole.substr(0, whole.size() - lost));
    ExpectError([&] { ReadImage(cut_name); }, {cut_name, "truncated"});
    WriteFileAtomically(cut_name, whole + "trailing bytes");
    EXPECT_NO_THROW(ReadImage(cut_name));
  }
}

TEST(ImageIo, BrokenImagesAreErrors) {
  const TemporaryFolder folder;
  ExpectError([&] { ReadImage(folder / "none.png"); }, {"none.png", "No such file"});
  ExpectError([&] { ReadImageInfo(folder / "none.png"); }, {"none.png", "No such file"});
  WriteFileAtomically(folder / "text.png", "not an image");
  ExpectError([&] { ReadImage(folder / "text.png"); }, {"text.png", "cannot be decoded"});
  WriteImage(folder / "a.png", Gradient(40, 30, 3));
  std::string flipped = Bytes(folder / "a.png");
  flipped[flipped.size() / 2] ^= 1;
  WriteFileAtomically(folder / "flipped.png", flipped);
  ExpectError([&] { ReadImage(folder / "flipped.png"); }, {"flipped.png", "checksum"});
  ExpectError([&] { WriteImage(folder / "a.xyz", Gradient(4, 4, 3)); }, {"a.xyz", "extension"});
  ExpectError([&] { WriteImage(folder / "a.jpg", Gradient(4, 4, 4)); }, {"a.jpg", "4 channels"});
  ExpectError([&] { WriteImage(folder / "e.png", Image8()); }, {"e.png", "0x0"});
  ExpectError([&] { WriteImage(folder / "no/a.png", Gradient(4, 4, 3)); }, {"no/a.png"});
}

// Sizes that some bytes cannot hold, which a decoder would allocate first.
TEST(ImageIo, SizesWithoutPixelsAreErrors) {
  const TemporaryFolder folder;
  const auto refuse = [&](const char* name, size_t at, const std::string& size) {
    WriteImage(folder / name, Gradient(40, 30, 3));
    std::string bytes = Bytes(folder / name);
    bytes.replace(at, size.size(), size);
    WriteFileAtomically(folder / name, bytes);
    ExpectError([&] { ReadImage(folder / name); }, {name, "pixels"});
  };
  refuse("huge.png", 16, std::string("\x00\x10\x00\x00\x00\x10\x00\x00", 8));
  refuse("negative.png", 16, std::string("\xff\xff\xff\xff\x00\x00\x00\x01", 8));
  refuse("empty.png", 16, std::string("\x00\x00\x00\x00\x00\x00\x00\x01", 8));
  refuse("large.png", 16, std::string("\x00\x00\x20\x00\x00\x00\x20\x00", 8));
  WriteImage(folder / "a.jpg", Gradient(40, 30, 3));
  const std::string frame("\x08\x00\x1e\x00\x28", 5);  // 8 bits, 30 rows of 40
  const size_t at = Bytes(folder / "a.jpg").find(frame);
  ASSERT_NE(at, std::string::npos);
  refuse("large.jpg", at + 1, "\x3f\xff\x3f\xff");
}

TEST(ImageIo, FloatsAreClampedAndRounded) {
  Image image(5, 1, 1);
  image.data = {-1, 0.4999f / 255, 0.5001f / 255, 1, 7};
  EXPECT_EQ(ToBytes(image).data, (std::vector<uint8_t>{0, 0, 1, 255, 255}));
  Image8 all(256, 1, 1);
  for (int i = 0; i < 256; ++i) all.data[i] = uint8_t(i);
  EXPECT_EQ(ToBytes(ToFloat(all)).data, all.data);
  image.data[3] = std::numeric_limits<float>::quiet_NaN();
  ExpectError([&] { ToBytes(image); }, {"pixel (3, 0)", "is NaN"});
}

TEST(ImageIo, ResizingAveragesTheArea) {
  Image8 image(4, 2, 1);
  image.data = {10, 20, 100, 100, 30, 40, 100, 200};
  const Image8 half = ResizeByArea(image, 2, 1);
  EXPECT_EQ(half.data, (std::vector<uint8_t>{25, 125}));
  EXPECT_EQ(ResizeByArea(image, 4, 2).data, image.data);
  EXPECT_EQ(ResizeByArea(Gradient(133, 237, 3), 50, 61).pixels(), 50u * 61);
  ExpectError([&] { ResizeByArea(image, 0, 2); }, {"4x2", "0x2"});
}

TEST(ImageIo, ColourUnderZeroAlphaDoesNotBleed) {
  Image8 image(2, 2, 4);
  image.data = {200, 100, 50, 255, 0, 255, 0, 0, 200, 100, 50, 255, 0, 255, 0, 0};
  const Image8 one = ResizeByArea(image, 1, 1);
  EXPECT_EQ(one.data, (std::vector<uint8_t>{200, 100, 50, 128}));
}

Camera TestCamera() {
  Camera camera;
  camera.width = 80;
  camera.height = 60;
  camera.fx = 70;
  camera.fy = 75;
  camera.cx = 41;
  camera.cy = 29.5f;
  return camera;
}

// The two lens models, written out from OpenCV's documentation.
std::array<double, 2> Distorted(const Distortion& d, const Camera& c, double x, double y) {
  const double r2 = x * x + y * y;
  if (d.model == Distortion::Model::kFisheye) {
    const double r = std::sqrt(r2), t = std::atan(r);
    const double theta = t * (1 + d.k[0] * std::pow(t, 2) + d.k[1] * std::pow(t, 4) +
                              d.k[2] * std::pow(t, 6) + d.k[3] * std::pow(t, 8));
    const double s = r > 0 ? theta / r : 1;
    return {c.fx * x * s + c.cx, c.fy * y * s + c.cy};
  }
  const double radial = (1 + d.k[0] * r2 + d.k[1] * r2 * r2 + d.k[4] * r2 * r2 * r2) /
                        (1 + d.k[5] * r2 + d.k[6] * r2 * r2 + d.k[7] * r2 * r2 * r2);
  return {c.fx * (x * radial + 2 * d.k[2] * x * y + d.k[3] * (r2 + 2 * x * x)) + c.cx,
          c.fy * (y * radial + d.k[2] * (r2 + 2 * y * y) + 2 * d.k[3] * x * y) + c.cy};
}

const Distortion kBrown{Distortion::Model::kBrown, {-.1, .02, .003, -.002, .01, .02, .005, .001}};
const Distortion kFisheye{Distortion::Model::kFisheye, {-.03, .01, .002, -.001}};

TEST(ImageIo, DistortionFollowsTheModels) {
  const Camera camera = TestCamera();
  for (const Distortion& distortion : {kBrown, kFisheye})
    for (double x : {3.0, 41.0, 77.0})
      for (double y : {1.0, 29.5, 55.0}) {
        const auto found = DistortedPixels(camera, distortion, camera, {{x, y}})[0];
        const auto expected =
            Distorted(distortion, camera, (x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy);
        EXPECT_NEAR(found[0], expected[0], 1e-9);
        EXPECT_NEAR(found[1], expected[1], 1e-9);
      }
}

// An image whose values are its own pixel coordinates shows where each output pixel comes from.
TEST(ImageIo, UndistortTakesPixelsFromWhereTheLensPutsThem) {
  const Camera source = TestCamera();
  Camera target = source;
  target.fx *= 1.2f;
  target.fy *= 1.2f;
  Image8 coordinates(source.width, source.height, 3);
  for (int y = 0; y < source.height; ++y)
    for (int x = 0; x < source.width; ++x) {
      coordinates.at(x, y, 0) = uint8_t(3 * x);
      coordinates.at(x, y, 1) = uint8_t(4 * y);
    }
  for (const Distortion& distortion : {kBrown, kFisheye}) {
    const Image8 result = Undistort(coordinates, source, distortion, target);
    for (int y = 5; y < 55; y += 9)
      for (int x = 5; x < 75; x += 9) {
        const auto from = Distorted(
            distortion, source, (x + .5 - target.cx) / target.fx, (y + .5 - target.cy) / target.fy);
        // Half a level of rounding, and OpenCV's 1/32 px steps of interpolation.
        EXPECT_NEAR(result.at(x, y, 0), 3 * (from[0] - .5), 0.5 + 3. / 32);
        EXPECT_NEAR(result.at(x, y, 1), 4 * (from[1] - .5), 0.5 + 4. / 32);
      }
  }
}

// Frame i is grey of level 20 i, with a brighter left half.
Image8 VideoFrame(int i) {
  Image8 frame(64, 48, 3, uint8_t(20 * i));
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 32; ++x) frame.at(x, y, 0) = uint8_t(20 * i + 40);
  return frame;
}

TEST(VideoIo, FramesComeBackInAnyOrder) {
  const TemporaryFolder folder;
  VideoWriter writer(folder / "v.mp4", 64, 48, 25);
  for (int i = 0; i < 10; ++i) writer.Write(VideoFrame(i));
  EXPECT_FALSE(std::filesystem::exists(folder / "v.mp4"));
  writer.Finish();
  VideoReader reader(folder / "v.mp4");
  ASSERT_EQ(reader.frame_count(), 10);
  for (int i : {0, 1, 7, 3, 3, 9}) {
    const Image8 frame = reader.ReadFrame(i);
    ASSERT_EQ(frame.width, 64);
    ASSERT_EQ(frame.channels, 3);
    EXPECT_NEAR(frame.at(10, 20, 0), 20 * i + 40, 6) << i;  // red: channels are in order
    EXPECT_NEAR(frame.at(50, 20, 2), 20 * i, 6) << i;
  }
  ExpectError([&] { reader.ReadFrame(10); }, {"v.mp4", "frame 10", "10"});
  ExpectError([&] { reader.ReadFrame(-1); }, {"v.mp4", "frame -1"});
}

TEST(VideoIo, BadVideosAreErrors) {
  const TemporaryFolder folder;
  ExpectError([&] { VideoReader(folder / "none.mp4"); }, {"none.mp4", "is not a file"});
  WriteFileAtomically(folder / "text.mp4", "not a video");
  ExpectError([&] { VideoReader(folder / "text.mp4"); }, {"text.mp4", "cannot be opened"});
  ExpectError([&] { VideoWriter(folder / "v.txt", 64, 48, 25); }, {"v.txt", ".mp4"});
  ExpectError([&] { VideoWriter(folder / "v.mp4", 0, 48, 25); }, {"v.mp4", "0x48"});
  ExpectError([&] { VideoWriter(folder / "no/v.mp4", 64, 48, 25); }, {"no/v.mp4"});
  {
    VideoWriter writer(folder / "v.mp4", 64, 48, 25);
    ExpectError([&] { writer.Write(Image8(64, 47, 3)); }, {"v.mp4", "64x47", "64x48"});
    writer.Write(VideoFrame(1));
  }  // not finished: nothing remains
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

}  // namespace
}  // namespace cosplat
