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
  Film film{.path = folder / "opaque.webm", .encoder = "libvpx-vp9", .alpha = true, .frames = {}};
  for (int i = 0; i < 5; ++i) film.frames.push_back({64, 48, 40 * i, 255});
  WriteFilm(film);
  ASSERT_TRUE(VideoReader(film.path).has_alpha());
  EXPECT_FALSE(FrameSource(film.path).has_alpha());
  film.frames[2].alpha = 0;
  WriteFilm(film);
  EXPECT_TRUE(FrameSource(film.path).has_alpha());
}

TEST(FrameSource, ScreenshotsOpaqueAlphaIsNoMatte) {
  const TemporaryFolder folder;
  for (const char* name : {"0.png", "1.png", "2.png"})
    WriteImage(folder / name, Image8(64, 48, 4, 255));
  EXPECT_FALSE(FrameSource(folder.path()).has_alpha());
  WriteImage(folder / "2.png", Image8(64, 48, 4, 0));
  EXPECT_TRUE(FrameSource(folder.path()).has_alpha());
}

}  // namespace
}  // namespace cosplat
