// cosplat play --headless as a user runs it, and what it says when something is wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

double MeanDifference(const Image8& a, const Image8& b) {
  EXPECT_EQ(a.data.size(), b.data.size());
  double sum = 0;
  for (size_t i = 0; i < a.data.size() && i < b.data.size(); ++i)
    sum += std::abs(int(a.data[i]) - int(b.data[i]));
  return sum / double(a.data.size());
}

CommandResult PlayInto(const std::string& out,
                       const std::string& model,
                       const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"play", model, "--headless", "-o", out, "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return Cosplat(arguments, "env -u DISPLAY -u WAYLAND_DISPLAY");
}

void ExpectLine(const CommandResult& result, const std::vector<std::string>& parts) {
  EXPECT_EQ(result.code, 2);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  for (const std::string& part : parts)
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err << " lacks " << part;
}

TEST(Play, DrivenFramesAreThoseOfRender) {
  const Workshop& w = Workshop::Get();
  const TemporaryFolder out;
  ASSERT_EQ(Cosplat({"render", "-m", w.avatar, "--drive", w.head, "-o", out / "a", "--quiet"}).code,
            0);
  const CommandResult played = PlayInto(out / "b", w.avatar, {"--drive", w.head});
  ASSERT_EQ(played.code, 0) << played.err;
  // The orbit's camera is the run's to rounding. Measured: 0.00.
  for (const char* frame : {"/00000.png", "/00007.png", "/00011.png"})
    EXPECT_LT(MeanDifference(ReadImage(out / "a" + frame), ReadImage(out / "b" + frame)), 0.05);
}

TEST(Play, EveryViewOfAnAvatarsFile) {
  const Workshop& w = Workshop::Get();
  const TemporaryFolder out;
  for (const std::string view : {"splats", "ellipsoids", "triangles", "wire"}) {
    const CommandResult played = PlayInto(
        out / view, w.avatar + "/avatar.glb", {"--view", view, "--size", "50x40", "--transparent"});
    ASSERT_EQ(played.code, 0) << played.err;
    const Image8 image = ReadImage(out / view + "/00000.png");
    EXPECT_EQ(image.width, 50);
    ASSERT_EQ(image.channels, 4);
    EXPECT_EQ(image.at(0, 0, 3), 0);
    EXPECT_GT(image.at(25, 20, 3), 150);
  }
}

TEST(Play, LevelsOfDetailShowTheScene) {
  const Workshop& w = Workshop::Get();
  const TemporaryFolder out;
  const std::string levels = out / "scene.levels";
  const CommandResult exported = Cosplat({"export", "-m", w.scene, "--levels", levels});
  ASSERT_EQ(exported.code, 0) << exported.err;
  EXPECT_NE(exported.out.find("scene.levels: "), std::string::npos) << exported.out;
  const std::string ply = w.scene + "/point_cloud/iteration_120/point_cloud.ply";
  ASSERT_EQ(PlayInto(out / "all", ply, {"--size", "64x64"}).code, 0);
  const CommandResult played = PlayInto(out / "levels", levels, {"--size", "64x64"});
  ASSERT_EQ(played.code, 0) << played.err;
  // Of fewer Gaussians than a block holds, which are all drawn, in another order.
  EXPECT_LT(MeanDifference(ReadImage(out / "all/00000.png"), ReadImage(out / "levels/00000.png")),
            0.05);
  const CommandResult info = Cosplat({"info", levels});
  EXPECT_NE(info.out.find("levels of detail: "), std::string::npos) << info.out << info.err;
  ExpectLine(PlayInto(out / "a", levels, {"--flame", w.model}), {"--flame", "is for avatars"});
  ExpectLine(Cosplat({"export", "--splats", levels, "--ply", out / "a.ply"}),
             {"scene.levels", "is not a splat file"});
}

TEST(Play, AFileAloneIsSeenFromTheFront) {
  const Workshop& w = Workshop::Get();
  const TemporaryFolder out;
  std::filesystem::copy(w.avatar + "/avatar.glb", out / "me.glb");
  const CommandResult played = PlayInto(out / "a", out / "me.glb", {"--size", "64x64"});
  ASSERT_EQ(played.code, 0) << played.err;
  EXPECT_GT(MeanDifference(ReadImage(out / "a/00000.png"), Image8(64, 64, 3, 255)), 10);
  const CommandResult info = Cosplat({"info", out / "me.glb"});
  EXPECT_NE(info.out.find("it may be passed on"), std::string::npos) << info.out << info.err;

  // Without its model in the file: readers ignore a field that they do not know.
  std::string bytes = test::Slurp(out / "me.glb");
  bytes.replace(bytes.find("\"file\":") + 1, 4, "none");
  std::ofstream(out / "bare.glb", std::ios::binary) << bytes;
  ExpectLine(PlayInto(out / "b", out / "bare.glb", {}),
             {"bare.glb", "--flame", "model.npz", "sha256"});
  ASSERT_EQ(PlayInto(out / "c", out / "bare.glb", {"--flame", w.model, "--size", "64x64"}).code, 0);
  EXPECT_EQ(ReadImage(out / "c/00000.png").data, ReadImage(out / "a/00000.png").data);
}

TEST(Play, AScenesTurnAsAVideo) {
  const Workshop& w = Workshop::Get();
  const TemporaryFolder out;
  const CommandResult played =
      PlayInto(out / "turn.mp4", w.scene, {"--frames", "6", "--view", "ellipsoids"});
  ASSERT_EQ(played.code, 0) << played.err;
  VideoReader video(out / "turn.mp4");
  ASSERT_EQ(video.frame_count(), 6);
  EXPECT_GT(MeanDifference(video.ReadFrame(0), video.ReadFrame(3)), 3);
}

TEST(Play, ScenesBeginAtACamera) {
  const Workshop& w = Workshop::Get();
  const TemporaryFolder out;
  ASSERT_EQ(PlayInto(out / "run", w.scene, {}).code, 0);
  ASSERT_EQ(Cosplat({"render", "-m", w.scene, "-o", out / "views", "--quiet"}).code, 0);
  const Image8 begun = ReadImage(out / "run/00000.png");
  EXPECT_LT(MeanDifference(begun, ReadImage(out / "views/00000.png")), 0.5);
  const std::string ply = w.scene + "/point_cloud/iteration_120/point_cloud.ply";
  ASSERT_EQ(PlayInto(out / "file", ply, {"--background", "white"}).code, 0);
  EXPECT_EQ(ReadImage(out / "file/00000.png").width, 768);
}

TEST(Play, SaysWhatIsWrong) {
  const Workshop& w = Workshop::Get();
  const TemporaryFolder out;
  ExpectLine(Cosplat({"play", w.avatar, "--headless"}), {"--out", "is needed"});
  // With a folder for sockets: libwayland, which GLFW 3.4 asks too, has a line of its own without.
  ExpectLine(Cosplat({"play", w.avatar}, "env -u DISPLAY -u WAYLAND_DISPLAY XDG_RUNTIME_DIR=/tmp"),
             {"display", "--headless"});
  ExpectLine(Cosplat({"play", w.avatar, "--device", "tpu"}), {"--device", "tpu"});
  ExpectLine(Cosplat({"play", w.avatar, "--size", "8x8"}), {"--size", "--headless"});
  ExpectLine(PlayInto(out / "a", w.avatar, {"--fps", "9"}), {"--fps", "--drive"});
  ExpectLine(PlayInto(out / "a", w.avatar, {"--view", "mesh"}), {"--view", "'mesh'", "wire"});
  ExpectLine(PlayInto(out / "a", w.avatar, {"--size", "12"}), {"--size", "'12'"});
  ExpectLine(PlayInto(out / "a", w.scene, {"--view", "wire"}),
             {"--view", "wire is only available for avatars"});
  ExpectLine(PlayInto(out / "a", w.scene, {"--drive", w.head}), {"--drive", "is for avatars"});
  ExpectLine(PlayInto(out / "a", w.scene, {"--flame", w.model}), {"--flame", "is for avatars"});
  ExpectLine(PlayInto(out / "a.mp4", w.avatar, {"--transparent"}), {"--transparent", "no alpha"});
  ExpectLine(PlayInto(out / "a", w.avatar, {"--drive", out / "none.npz"}), {"none.npz"});
  ExpectLine(PlayInto(out / "a", w.avatar, {"--drive", "udp://:0"}), {"'udp://:0'", "window"});
  ExpectLine(PlayInto(out / "a", w.avatar, {"--drive", "ftp://:0"}), {"ftp://:0"});
  ExpectLine(PlayInto(out / "a", out / "none", {}), {"none"});
  EXPECT_FALSE(std::filesystem::exists(out / "a"));
}

}  // namespace
}  // namespace cosplat::test
