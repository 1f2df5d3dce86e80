// cosplat stream: into a pipe in a camera's place, and as a stream that FFmpeg's reader takes.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

constexpr int kWidth = 64, kHeight = 48;

CommandResult Stream(const std::string& to, const std::vector<std::string>& more) {
  std::vector<std::string> arguments{
      "stream", Workshop::Get().avatar, "--to", to, "--size", "64x48", "--fps", "60"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return Cosplat(arguments, "env -u DISPLAY -u WAYLAND_DISPLAY timeout 60");
}

void ExpectRefused(const CommandResult& result, const std::string& words) {
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
}

TEST(Stream, FillsAPipeInACamerasPlace) {
  const TemporaryFolder folder;
  const std::string pipe = folder / "camera";
  ASSERT_EQ(std::system(("mkfifo '" + pipe + "'").c_str()), 0);
  std::string bytes;
  std::thread reader([&] { bytes = Slurp(pipe); });
  const CommandResult result =
      Stream("v4l2:" + pipe, {"--frames", "20", "--background", "#ff0000"});
  reader.join();
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("64x48 at 60 frames/s"), std::string::npos) << result.out;
  int written = 0, left_out = 0;
  const size_t last = result.out.find('\n') + 1;
  ASSERT_EQ(std::sscanf(result.out.c_str() + last, "%d frames, %d left out", &written, &left_out),
            2)
      << result.out;
  EXPECT_GE(written + left_out, 20);
  ASSERT_EQ(bytes.size(), size_t(written) * kWidth * kHeight * 3 / 2);
  // Red in the corner, by BT.601; something else where the head is.
  const auto at = [&](int plane_begin, int width, int x, int y) {
    return int(uint8_t(bytes[size_t(plane_begin + y * width + x)]));
  };
  EXPECT_NEAR(at(0, kWidth, 1, 1), 81, 2);
  EXPECT_NEAR(at(kWidth * kHeight, kWidth / 2, 0, 0), 90, 2);
  EXPECT_NEAR(at(kWidth * kHeight * 5 / 4, kWidth / 2, 0, 0), 240, 2);
  EXPECT_GT(std::abs(at(0, kWidth, 32, 24) - 81), 10);
  // It stands on the picture's lower edge.
  EXPECT_GT(std::abs(at(kWidth * kHeight * 5 / 4, kWidth / 2, 16, kHeight / 2 - 1) - 240), 20);
}

TEST(Stream, IsReadByFfmpegsReader) {
  const Workshop& w = Workshop::Get();
  const TemporaryFolder folder;
  // Twice as wide as high: the left and the right quarter of it are cut.
  Image8 behind(96, 48, 3, 0);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 96; ++x) behind.at(x, y, 2) = x < 16 ? 0 : 200;
  WriteImage(folder / "behind.png", behind);
  const std::string video = folder / "out.ts";
  const CommandResult result = Stream(
      "file:" + video,
      {"--drive", w.head, "--frames", "30", "--background", folder / "behind.png", "--quiet"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(result.out.empty()) << result.out;
  VideoReader reader(video);
  ASSERT_GT(reader.frame_count(), 3);
  const Image8 frame = reader.ReadFrame(reader.frame_count() - 1);
  EXPECT_EQ(frame.width, kWidth);
  EXPECT_EQ(frame.height, kHeight);
  EXPECT_NEAR(frame.at(1, 1, 2), 200, 15);
  EXPECT_NEAR(frame.at(1, 1, 0), 0, 15);
}

TEST(Stream, NamesWhatIsWrong) {
  const TemporaryFolder folder;
  WriteImage(folder / "a.png", Image8(8, 8, 3));
  ExpectRefused(Stream("nowhere", {}), "nowhere: expected v4l2:DEVICE");
  ExpectRefused(Stream("v4l2:" + (folder / "none"), {}), "none: No such file");
  ExpectRefused(Stream("v4l2:" + (folder / "a.png"), {}), "is no video output");
  ExpectRefused(Stream("tcp://127.0.0.1:1", {}), "tcp://127.0.0.1:1: video cannot be written");
  ExpectRefused(Stream("file:a.MP4", {}), "file:a.MP4: is written as MPEG-TS");
  ExpectRefused(Stream("file:/dev/null", {"--background", "#12345"}),
                "--background: found '#12345'");
  ExpectRefused(Stream("file:/dev/null", {"--background", "#-12345"}), "found '#-12345'");
  ExpectRefused(Stream("file:/dev/null", {"--background", folder / "b.png"}), "b.png");
  const CommandResult camera = Stream("file:/dev/null", {"--drive", "webcam:no.y4m"});
  ExpectRefused(camera, "webcam:no.y4m: has ended");
  ExpectRefused(camera, "no.y4m: cannot be opened");
  const CommandResult at_end = Stream("file:/dev/null", {"--drive", "stdin:"});  // which is empty
  EXPECT_EQ(at_end.code, 0) << at_end.err;
}

}  // namespace
}  // namespace cosplat::test
