// Frames that a program filled up with bars beside the picture.
#include <gtest/gtest.h>

#include <cmath>

#include "apps/cosplat/run/frame_source.h"
#include "splat/base/files.h"
#include "splat/base/rng.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

constexpr int kWidth = 320, kHeight = 180, kBegin = 110, kEnd = 210;

enum class Beside { kBlur, kBlack, kPicture };

uint8_t Blurred(int x, int y) { return uint8_t(70 + 40 * std::sin(0.02 * x + 0.03 * y)); }

// A picture with detail from column kBegin to kEnd; what is to the left and right of it.
Image8 Frame(Beside left, Beside right) {
  Image8 image(kWidth, kHeight, 3);
  Rng rng;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const Beside here = x < kBegin ? left : x >= kEnd ? right : Beside::kPicture;
      const uint8_t detail = uint8_t(130 + rng.Below(60));
      const uint8_t value = here == Beside::kBlur    ? Blurred(x, y)
                            : here == Beside::kBlack ? 0
                                                     : detail;
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = value;
    }
  return image;
}

Image8 Turned(const Image8& image) {
  Image8 turned(image.height, image.width, 3);
  for (int y = 0; y < turned.height; ++y)
    for (int x = 0; x < turned.width; ++x)
      for (int c = 0; c < 3; ++c) turned.at(x, y, c) = image.at(y, x, c);
  return turned;
}

void ExpectNone(const std::vector<Image8>& frames, const char* of) {
  const auto picture = PictureBetweenBars(frames);
  ASSERT_TRUE(picture) << of;
  EXPECT_EQ(picture->width, frames[0].width) << of;
  EXPECT_EQ(picture->height, frames[0].height) << of;
}

// A codec smears the edges: some columns of the picture may go.
void ExpectBetween(int begin, int end, int from, int size) {
  EXPECT_GE(from, begin);
  EXPECT_LE(from, begin + 3);
  EXPECT_LE(from + size, end);
  EXPECT_GE(from + size, end - 3);
}

TEST(PictureBetweenBars, IsFoundBetweenBlurredAndBlackOnes) {
  for (const Beside bar : {Beside::kBlur, Beside::kBlack}) {
    const Image8 frame = Frame(bar, bar);
    const auto across = PictureBetweenBars({frame}), down = PictureBetweenBars({Turned(frame)});
    ASSERT_TRUE(across && down);
    ExpectBetween(kBegin, kEnd, across->x, across->width);
    EXPECT_EQ(across->height, kHeight);
    ExpectBetween(kBegin, kEnd, down->y, down->height);
    EXPECT_EQ(down->width, kHeight);
  }
}

TEST(PictureBetweenBars, IsAllWhereThereAreNone) {
  ExpectNone({Frame(Beside::kPicture, Beside::kPicture)}, "detail everywhere");
  ExpectNone({Frame(Beside::kBlur, Beside::kPicture)}, "what is soft on one side is no bar");
  // Somebody before a wall: no edge goes through the frame.
  Image8 person = Frame(Beside::kBlack, Beside::kBlack);
  for (int y = 0; y < kHeight / 2 + 10; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) person.at(x, y, c) = 0;
  ExpectNone({person}, "a person before a black wall");
  EXPECT_FALSE(PictureBetweenBars({Image8(kWidth, kHeight, 3, 0)})) << "nothing to see";
}

TEST(FrameSource, RefusesTwoImagesOfOneName) {
  const TemporaryFolder folder;
  for (const char* name : {"a_1.png", "a_2.jpg", "a_2.k.png", "a_2.png"})
    WriteImage(folder / name, Image8(64, 48, 3));
  ExpectError([&] { FrameSource(folder.path()); }, {"a_2.jpg", "a_2.png", "one frame"});
  RemoveFile(folder / "a_2.png");
  EXPECT_EQ(FrameSource(folder.path()).count(), 3);
}

TEST(FrameSource, LeavesBarsOut) {
  const TemporaryFolder folder;
  const std::string images = folder / "images";
  MakeDirectories(images);
  WriteImage(images + "/1.png", Frame(Beside::kPicture, Beside::kPicture));  // a title
  for (const int i : {2, 3, 4})
    WriteImage(images + "/" + std::to_string(i) + ".png", Frame(Beside::kBlur, Beside::kBlur));
  FrameSource frames(images);
  ExpectBetween(kBegin, kEnd, frames.picture().x, frames.width());
  EXPECT_EQ(frames.picture().width, frames.width());
  EXPECT_EQ(frames.height(), kHeight);
  ASSERT_EQ(frames.notes().size(), 1u);
  EXPECT_NE(frames.notes()[0].find("of 320x180: the bars beside it"), std::string::npos)
      << frames.notes()[0];
  const Image8 read = frames.Read(2);
  EXPECT_EQ(read.width, frames.width());
  EXPECT_GE(read.at(0, 90, 0), 130);
  // For landmarks that somebody found in whole frames.
  frames.EndAt(frames.in_file());
  EXPECT_EQ(frames.Read(2).width, kWidth);
  EXPECT_TRUE(frames.notes().empty());
  EXPECT_EQ(FrameSource(images, Bars::kKeep).width(), kWidth);
}

}  // namespace
}  // namespace cosplat
