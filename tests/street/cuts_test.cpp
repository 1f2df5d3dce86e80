// Videos that are cut from one shot to another.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "apps/cosplat/run/frame_source.h"
#include "splat/base/files.h"
#include "splat/base/rng.h"
#include "splat/media/frame_cuts.h"
#include "tests/street/film.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::TemporaryFolder;

constexpr int kSide = 64;

// A bright disk before a shaded wall, with noise.
Image8 Frame(double x, double radius, int seed) {
  Image8 image(kSide, kSide, 3);
  Rng rng(uint64_t(seed) + 1);
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u) {
      const bool inside = std::hypot(u - x, v - 32) < radius;
      const int value = (inside ? 200 : 40 + u) + int(rng.Below(8));
      for (int c = 0; c < 3; ++c) image.at(u, v, c) = uint8_t(value);
    }
  return image;
}

std::vector<int> CutsOf(int count, const std::function<Image8(int)>& frame) {
  CutFinder finder;
  for (int i = 0; i < count; ++i) {
    const Image8 image = frame(i);
    finder.Add({image.data.data(), 3 * kSide, 3, 8, 0, kSide, kSide});
  }
  return finder.Cuts();
}

TEST(Cuts, AreWhereThePictureChangesAtOnce) {
  EXPECT_EQ(CutsOf(40, [](int i) { return Frame(i < 17 ? 20 : 44, 12, i); }), std::vector<int>{17});
  EXPECT_EQ(CutsOf(40, [](int i) { return Frame(32, i < 20 ? 14 : 20, i); }), std::vector<int>{20})
      << "nearer";
  EXPECT_EQ(CutsOf(40, [](int i) { return Frame(i < 17 || i >= 21 ? 20 : 44, 12, i); }),
            (std::vector<int>{17, 21}))
      << "soon again";
  EXPECT_EQ(CutsOf(40, [](int i) { return Frame(30, i < 3 || i > 36 ? 6 : 25, i); }),
            (std::vector<int>{3, 37}))
      << "near the ends";
}

TEST(Cuts, AreNotWhereItMoves) {
  const std::vector<int> none;
  EXPECT_EQ(CutsOf(40, [](int i) { return Frame(10 + 1.2 * i, 12, i); }), none);
  EXPECT_EQ(CutsOf(40, [](int i) { return Frame(32 + 20 * std::sin(0.8 * i), 12, i); }), none)
      << "shaken";
  EXPECT_EQ(CutsOf(40, [](int i) { return Frame(32, 5 + 0.5 * i, i); }), none) << "zoomed";
  // A camera of five frames a second in a file of 25 or 30.
  for (const int held : {3, 5, 6})
    EXPECT_EQ(CutsOf(60, [&](int i) { return Frame(12 + 4 * (i / held), 12, i / held); }), none)
        << held;
  EXPECT_EQ(CutsOf(2, [](int i) { return Frame(32, 12, i); }), none);
  EXPECT_EQ(CutsOf(0, [](int) { return Image8(); }), none);
}

// Of 8 and 10 bits, of two planes, of packed RGB, and of a folder's images.
TEST(Cuts, AreFoundInAnyFile) {
  const TemporaryFolder folder;
  int at = 0;
  for (const auto& [format, encoder] : {std::pair(AV_PIX_FMT_YUV420P, "ffv1"),
                                        std::pair(AV_PIX_FMT_YUV420P10, "ffv1"),
                                        std::pair(AV_PIX_FMT_GBRP10, "ffv1"),
                                        std::pair(AV_PIX_FMT_RGB24, "png")}) {
    const int bits = av_pix_fmt_desc_get(format)->comp[0].depth;
    test::Film film;
    film.path = folder / (std::to_string(at) + ".mkv");
    film.encoder = encoder;
    film.format = format;
    film.frames = test::Frames(30, kSide, kSide);
    int frame = 0;
    film.fill = [&](AVFrame& picture) {
      const int value = (frame++ < 12 ? 60 : 120) << (bits - 8);
      for (int plane = 0; plane < 4 && picture.data[plane] != nullptr; ++plane) {
        const int rows = plane > 0 && format != AV_PIX_FMT_GBRP10 ? kSide / 2 : kSide;
        for (int y = 0; y < rows; ++y) {
          uint8_t* const row = picture.data[plane] + y * picture.linesize[plane];
          if (bits > 8)
            std::fill_n(reinterpret_cast<uint16_t*>(row), picture.linesize[plane] / 2, value);
          else
            std::memset(row, value, size_t(picture.linesize[plane]));
        }
      }
    };
    test::WriteFilm(film);
    EXPECT_EQ(FrameSource(film.path).Cuts(), std::vector<int>{12}) << at;
    ++at;
  }
  const std::string images = folder / "images";
  MakeDirectories(images);
  for (int i = 0; i < 20; ++i)
    WriteImage(images + "/" + std::to_string(i) + ".png", Frame(i < 8 ? 20 : 44, 12, i));
  EXPECT_EQ(FrameSource(images).Cuts(), std::vector<int>{8});
}

}  // namespace
}  // namespace cosplat
