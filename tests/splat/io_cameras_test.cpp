// splat/io/cameras_json.h: the cameras of a model folder, written and read.
#include <gtest/gtest.h>

#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/io/cameras_json.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

Camera Turned() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 500;
  camera.fy = 510;
  camera.cx = 320;
  camera.cy = 240;
  camera.rotation = {0, 1, 0, -1, 0, 0, 0, 0, 1};
  camera.translation = {1, 2, 3};
  return camera;
}

TEST(CamerasJson, HasTheFieldsThatViewersRead) {
  const TemporaryFolder folder;
  const Camera camera = Turned();
  WriteCamerasJson(folder / "cameras.json", {{"a", camera}, {"b", camera}});
  const auto json = ReadJson(folder / "cameras.json");
  ASSERT_EQ(json.size(), 2u);
  EXPECT_EQ(json[1]["id"], 1);
  EXPECT_EQ(json[1]["img_name"], "b");
  EXPECT_EQ(json[0]["width"], 640);
  EXPECT_EQ(json[0]["fy"], 510);
  // world_from_cam: the transpose, and -R^T t.
  EXPECT_EQ(json[0]["rotation"], (Json{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}));
  EXPECT_EQ(json[0]["position"], (Json{2, -1, -3}));
}

TEST(CamerasJson, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const Camera camera = Turned();
  WriteCamerasJson(folder / "cameras.json", {{"a", camera}});
  const std::vector<NamedCamera> read = ReadCamerasJson(folder / "cameras.json");
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].name, "a");
  EXPECT_EQ(read[0].camera.width, 640);
  EXPECT_EQ(read[0].camera.fy, 510);
  EXPECT_EQ(read[0].camera.cx, 320);
  EXPECT_EQ(read[0].camera.rotation, camera.rotation);
  EXPECT_EQ(read[0].camera.translation, camera.translation);
}

TEST(CamerasJson, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  const auto refuses = [&](const char* key, Json value, const char* part) {
    Camera camera;
    camera.width = camera.height = 8;
    camera.fx = camera.fy = 8;
    WriteCamerasJson(folder / "cameras.json", {{"a", camera}, {"b", camera}});
    auto json = ReadJson(folder / "cameras.json");
    json[1][key] = std::move(value);
    WriteFileAtomically(folder / "cameras.json", json.dump());
    ExpectError([&] { ReadCamerasJson(folder / "cameras.json"); }, {"cameras.json", "[1]", part});
  };
  refuses("fx", 0, "not positive");
  refuses("width", -3, "not positive");
  refuses("position", {1, 2}, "position");
  refuses("rotation", {1, 0, 0, 0, 1, 0, 0, 0, 2}, "rotation");
  refuses("img_name", nullptr, "img_name");
}

}  // namespace
}  // namespace cosplat::test
