// tests/plugin/host.c, compiled as strict C99: what docs/plugin.md shows runs, and gives the
// player's pixels.
#include <cstdlib>

#include "avatar/play/player.h"
#include "splat/base/files.h"
#include "tests/plugin/plugin_fixture.h"

namespace cosplat::test {
namespace {

int RunHost(const std::string& arguments) {
  return std::system((std::string(COSPLAT_HOST) + " " + arguments + " 2>/dev/null").c_str());
}

TEST(PluginHost, WritesTheFrame) {
  const PluginFiles& files = PluginFiles::Get();
  const std::string out = files.folder / "frame.pam";
  ASSERT_EQ(RunHost(files.avatar_path + " " + files.flame_path + " " + out), 0);
  FlameParams params;
  params.expression = {1};
  params.pose[COSPLAT_JOINT_JAW][0] = 0.1f;
  const OpenAvatar avatar;
  const Camera camera = CameraOf([&] {
    cosplat_camera c = Zeroed<cosplat_camera>();
    EXPECT_EQ(cosplat_orbit_camera(avatar, 256, 256, 0, 0, 1, &c), COSPLAT_OK);
    return c;
  }());
  Player player(files.avatar, files.flame);
  const Image8 expected = player.Render(params, camera);
  const auto bytes = ReadFile(out);
  ASSERT_GT(bytes.size(), expected.data.size());
  EXPECT_TRUE(std::equal(expected.data.begin(),
                         expected.data.end(),
                         bytes.end() - ptrdiff_t(expected.data.size()),
                         [](uint8_t a, auto b) { return a == uint8_t(b); }));
}

TEST(PluginHost, FailsInOneLine) {
  const PluginFiles& files = PluginFiles::Get();
  EXPECT_NE(RunHost(""), 0);
  EXPECT_NE(RunHost("/nowhere.glb " + files.flame_path + " " + files.folder / "x"), 0);
}

}  // namespace
}  // namespace cosplat::test
