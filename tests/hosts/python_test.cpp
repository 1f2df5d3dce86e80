// What is in apps/python as a user runs it: it shows the library's pictures.
#include <cstdlib>

#include "splat/base/files.h"
#include "splat/media/image_io.h"
#include "tests/hosts/expected_picture.h"

namespace cosplat::test {
namespace {

int RunExample(const std::string& arguments) {
  return std::system(("python3 " COSPLAT_PYTHON_EXAMPLE " " + arguments).c_str());
}

std::string AvatarAnd(const std::string& arguments) {
  const PluginFiles& files = PluginFiles::Get();
  return files.avatar_path + " " + files.flame_path + " " + arguments;
}

TEST(Python, WritesTheLibrarysPictures) {
  const std::string out = PluginFiles::Get().folder / "out.png";
  Wanted wanted{96, 96, 30};
  wanted.alpha = COSPLAT_ALPHA_STRAIGHT;
  ASSERT_EQ(RunExample(AvatarAnd(out + " --size 96 --jaw 0.2 --azimuth 30")), 0);
  const OpenAvatar avatar;
  const float jaw[3] = {0.2f, 0, 0};
  ASSERT_EQ(cosplat_set_joint(avatar, COSPLAT_JOINT_JAW, jaw, 0), COSPLAT_OK);
  EXPECT_EQ(ReadImage(out).data, Draw(avatar, wanted));

  const std::string drive = WriteRecording(10, 25);
  ASSERT_EQ(RunExample(AvatarAnd(out + " --size 96 --azimuth 30 --at 0.2 --drive " + drive)), 0);
  ASSERT_EQ(cosplat_reset_parameters(avatar), COSPLAT_OK);
  ASSERT_EQ(cosplat_set_drive(avatar, drive.c_str()), COSPLAT_OK);
  for (int64_t n = 0; n <= 5; ++n) ASSERT_EQ(cosplat_advance(avatar, n * 40'000'000), COSPLAT_OK);
  EXPECT_EQ(ReadImage(out).data, Draw(avatar, wanted));
}

TEST(Python, FailsInOneLine) {
  const PluginFiles& files = PluginFiles::Get();
  const std::string out = files.folder / "no.png", said = files.folder / "said.txt";
  EXPECT_NE(RunExample("/nowhere/a.glb " + files.flame_path + " " + out + " 2>" + said), 0);
  cosplat_avatar* avatar = nullptr;
  const cosplat_open_options options = OpenOptions();
  ASSERT_NE(cosplat_open("/nowhere/a.glb", &options, &avatar), COSPLAT_OK);
  const auto text = ReadFile(said);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(text.data()), text.size()),
            "render_png.py: " + std::string(cosplat_last_error(nullptr)) + "\n");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(Python, OpensAThousandAndDrawsFromThreads) {
  EXPECT_EQ(std::system(("python3 " COSPLAT_PYTHON_MANY " " + AvatarAnd("")).c_str()), 0);
}

TEST(Python, ShowsAnAvatarInBlender) {
  if (std::system("blender --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "needs Blender";
  const TemporaryFolder out;
  const std::string said = out / "said.txt";
  const std::string command =
      "blender -b --factory-startup -noaudio --python-exit-code 1 --python " COSPLAT_BLENDER_TEST
      " -- " +
      AvatarAnd(out.path());
  EXPECT_EQ(std::system((command + " >" + said + " 2>&1 || { cat " + said + "; false; }").c_str()),
            0);
}

}  // namespace
}  // namespace cosplat::test
