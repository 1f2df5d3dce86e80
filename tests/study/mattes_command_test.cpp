// `cosplat-study mattes` as a user runs it.
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "flame/io/landmarks.h"
#include "splat/media/image_io.h"
#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

TEST(MattesCommand, PrintsErrorsBeforeAndAfter) {
  const TemporaryFolder folder;
  const CommandResult result =
      Cosplat({"mattes", "--frames", "12", "--size", "256", "--seed", "3", "-o", folder / "out"});
  ASSERT_EQ(result.code, 0) << result.err;
  std::istringstream lines(result.out);
  std::string line, background, what;
  std::getline(lines, line);  // of titles
  double network = 0, rim = 0, refined = 0;
  for (const char* name : {"still", "moving", "busy"}) {
    lines >> background >> what >> network >> rim;
    EXPECT_EQ(background + what, std::string(name) + "network");
    EXPECT_GT(network, 0);
    EXPECT_GT(rim, network);
    lines >> background >> what >> refined >> rim;
    EXPECT_EQ(background + what, std::string(name) + "refined");
    EXPECT_LT(refined, network / 2) << name;
    const Image8 sheet = ReadImage(folder / ("out/" + std::string(name) + "0.png"));
    EXPECT_EQ(sheet.width, 3 * 256);
  }
}

TEST(MattesCommand, DrawsAFilmsOwn) {
  const TemporaryFolder folder;
  LandmarkVideo video;
  video.source = folder / "images";
  video.width = video.height = 32;
  std::filesystem::create_directories(folder / "images");
  std::filesystem::create_directories(folder / "mattes");
  for (int f = 0; f < 6; ++f) {
    const std::string name = std::to_string(f), matte = folder / ("mattes/" + name + ".png");
    WriteImage(folder / ("images/" + name + ".png"), Image8(32, 32, 3, 90));
    WriteImage(matte, Image8(32, 32, 1, 255));
    video.frames.push_back({name, f, {}, matte});
  }
  WriteLandmarks(folder / "marks.json", video);
  const CommandResult result =
      Cosplat({"mattes", "--landmarks", folder / "marks.json", "-o", folder / "out"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(ReadImage(folder / "out/0.png").width, 3 * 32);
}

}  // namespace
}  // namespace cosplat::test
