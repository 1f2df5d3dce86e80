// Frames with an alpha that says nothing of a person.
#include <gtest/gtest.h>

#include "apps/cosplat/run/frame_source.h"
#include "splat/media/image_io.h"
#include "tests/street/film.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::Film;
using test::TemporaryFolder;
using test::WriteFilm;

TEST(FrameSource, AVideosOpaqueAlphaIsNoMatte) {
  const TemporaryFolder folder;
  Film film{.path = folder / "some.webm", .encoder = "libvpx-vp9", .alpha = true, .frames = {}};
  for (int i = 0; i < 5; ++i) film.frames.push_back({64, 48, 40 * i, uint8_t(i == 2 ? 64 : 255)});
  WriteFilm(film);
  const FrameSource frames(film.path);
  for (int i = 0; i < 5; ++i) ASSERT_EQ(frames.Matte(i).has_value(), i == 2) << i;
  EXPECT_NEAR(frames.Matte(2)->data[0], 64, 3);
}

TEST(FrameSource, AScreenshotsOpaqueAlphaIsNoMatte) {
  const TemporaryFolder folder;
  Image8 cut_out(64, 48, 4, 255);
  cut_out.at(5, 7, 3) = 0;
  WriteImage(folder / "0.png", Image8(64, 48, 3, 255));
  WriteImage(folder / "1.png", Image8(64, 48, 4, 255));
  WriteImage(folder / "2.png", cut_out);
  const FrameSource frames(folder.path());
  EXPECT_FALSE(frames.Matte(0));
  EXPECT_FALSE(frames.Matte(1));
  ASSERT_TRUE(frames.Matte(2));
  EXPECT_EQ(frames.Matte(2)->at(5, 7, 0), 0);
  EXPECT_EQ(frames.Matte(2)->at(7, 5, 0), 255);
}

}  // namespace
}  // namespace cosplat
