// `cosplat landmarks`, with programs that stand in for node, npm and Chromium, and with the real
// ones where they are installed.
#include "flame/io/landmarks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "splat/base/files.h"
#include "splat/base/json.h"
#include "tests/integration/command.h"

namespace cosplat {
namespace {

using test::CommandResult;
using test::Cosplat;
using test::TemporaryFolder;

constexpr int kSide = 32;

// A folder of programs for PATH, a cache, and a video of three images.
struct Stage {
  TemporaryFolder folder;
  std::string images = folder / "images", out = folder / "out/marks.json";

  Stage() {
    MakeDirectories(images);
    MakeDirectories(folder / "out");
    MakeDirectories(folder / "bin");
    for (int i = 8; i < 11; ++i)
      WriteImage(images + "/" + std::to_string(i) + ".png", Image8(kSide, kSide, 3, 90));
    Program("npm", "mkdir -p node_modules");
    Program("chromium", "exit 0");
  }

  void Program(const std::string& name, const std::string& body) const {
    const std::string path = folder / ("bin/" + name);
    std::ofstream(path) << "#!/bin/sh\n" << body << "\n";
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }

  // node, as detect.mjs leaves its folder of frames: each face is the same 478 points.
  void Node(const std::string& faces) const {
    std::ofstream(folder / "matte", std::ios::binary) << std::string(kSide * kSide, char(255));
    Program("node",
            "while [ \"$1\" != --frames ]; do shift; done\n"
            "for i in 0 1 2; do cp '" +
                (folder / "matte") +
                "' $2/$i.matte; "
                "echo frame $((i + 1)); done\ncp '" +
                (folder / "faces.json") + "' $2/faces.json");
    std::ofstream(folder / "faces.json") << faces;
  }

  // The same, for any number of images.
  void NodeOfOneFace() const {
    Node(Face());
    Program("node",
            "while [ \"$1\" != --frames ]; do shift; done\n"
            "i=0; comma='['\n"
            "while [ -e $2/$i.jpg ]; do cp '" +
                (folder / "matte") + "' $2/$i.matte; printf \"$comma\"; comma=,; cat '" +
                (folder / "faces.json") +
                "'; i=$((i + 1)); done >$2/faces.json; echo ']' >>$2/faces.json");
  }

  static std::string Face() {
    Json points = Json::array();
    for (int i = 0; i < 478; ++i) points.push_back({i % 30, i % 17});
    return Json::array({points}).dump();
  }

  CommandResult Run(const std::vector<std::string>& more = {}) const { return RunTo(out, more); }

  CommandResult RunTo(const std::string& marks, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"landmarks", images, "-o", marks};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Cosplat(arguments,
                   "PATH='" + (folder / "bin") + ":/usr/bin:/bin' XDG_CACHE_HOME='" +
                       (folder / "cache") + "'");
  }

  void ExpectRefused(const std::vector<std::string>& words) const {
    const CommandResult result = Run();
    EXPECT_EQ(result.code, 2);
    for (const std::string& word : words)
      EXPECT_NE(result.err.find(word), std::string::npos) << result.err << " lacks " << word;
    EXPECT_TRUE(std::filesystem::is_empty(folder / "out")) << "something was written";
  }
};

TEST(Landmarks, AreWrittenWithMattesAndScores) {
  const Stage stage;
  stage.Node("[" + Stage::Face() + ",[]," + Stage::Face() + "]");
  const CommandResult result = stage.Run();
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("Installing MediaPipe"), std::string::npos) << result.err;
  EXPECT_NE(result.out.find("faces in 2 of 3 frames"), std::string::npos) << result.out;
  const LandmarkVideo video = ReadLandmarks(stage.out);
  ASSERT_EQ(video.frames.size(), 3u);
  const char* const names[] = {"8", "9", "10"};  // as people count
  for (size_t f = 0; f < 3; ++f) {
    EXPECT_EQ(video.frames[f].name, names[f]);
    EXPECT_EQ(video.frames[f].faces.size(), f == 1 ? 0u : 1u);
    const Image8 matte = ReadImage(video.frames[f].matte);
    EXPECT_EQ(matte.channels, 1);
    EXPECT_EQ(matte.data[0], 255);
  }
  EXPECT_EQ(video.frames[0].faces[0].blendshapes.count("jawOpen"), 1u);
  // The packages are there now.
  stage.Program("npm", "exit 1");
  EXPECT_EQ(stage.Run().code, 0);
}

// The head is looked for first; then all is about its part of the frames.
TEST(Landmarks, AreThoseOfTheHeadsPart) {
  const Stage stage;
  for (int i = 8; i < 11; ++i)
    WriteImage(stage.images + "/" + std::to_string(i) + ".png", Image8(80, 80, 3, 90));
  stage.Node("[" + Stage::Face() + "," + Stage::Face() + "," + Stage::Face() + "]");
  const CommandResult result = stage.Run({"--size", std::to_string(kSide)});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("68x68 at 0, 0 of 80x80, as 32x32"), std::string::npos) << result.out;
  const LandmarkVideo video = ReadLandmarks(stage.out);
  ASSERT_TRUE(video.crop);
  EXPECT_EQ(video.crop->part.height, 68);
  EXPECT_EQ(video.width, kSide);
  EXPECT_EQ(ReadImageInfo(video.frames[2].matte).width, kSide);
  // A choice of frames is exact.
  ASSERT_EQ(stage.Run({"--size", std::to_string(kSide), "--frames", "2"}).code, 0);
  const LandmarkVideo two = ReadLandmarks(stage.out);
  ASSERT_EQ(two.frames.size(), 2u);
  EXPECT_EQ(two.frames[1].name, "10");
  EXPECT_EQ(two.held_out, 1);
}

TEST(Landmarks, AreThoseOfShotsThatShowOnePerson) {
  const Stage stage;
  stage.NodeOfOneFace();
  for (int i = 8; i < 40; ++i) {
    const bool other = i >= 20 && i < 30;  // frames 12 to 21
    WriteImage(stage.images + "/" + std::to_string(i) + ".png",
               Image8(kSide, kSide, 3, other ? 180 : 90));
  }
  const CommandResult result = stage.Run();
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("3 shots; 2 of them, 22 of 32 frames, show one face"),
            std::string::npos)
      << result.err;
  const LandmarkVideo video = ReadLandmarks(stage.out);
  ASSERT_EQ(video.frames.size(), 22u);
  EXPECT_EQ(video.frames[11].name, "19");
  EXPECT_EQ(video.frames[12].frame, 22);
  EXPECT_EQ(video.left_out, 10);
  ASSERT_EQ(stage.Run({"--frames", "10"}).code, 0);
  const LandmarkVideo ten = ReadLandmarks(stage.out);
  ASSERT_EQ(ten.frames.size(), 10u);
  for (const LandmarkFrame& frame : ten.frames) EXPECT_TRUE(frame.frame < 12 || frame.frame >= 22);
}

// Frame by frame: some programs cut out what they find, and leave other images as they are.
TEST(Landmarks, TakeAlphaThatIsNotOpaqueEverywhere) {
  const Stage stage;
  stage.Node("[" + Stage::Face() + "," + Stage::Face() + "," + Stage::Face() + "]");
  std::ofstream(stage.folder / "matte", std::ios::binary) << std::string(kSide * kSide, char(0));
  Image8 cut_out(kSide, kSide, 4, 90);
  for (size_t i = 3; i < cut_out.data.size(); i += 4) cut_out.data[i] = 255;
  WriteImage(stage.images + "/9.png", cut_out);
  for (size_t i = 0; i < cut_out.pixels(); ++i) cut_out.data[4 * i + 3] = i % kSide < 9 ? 0 : 255;
  WriteImage(stage.images + "/10.png", cut_out);
  const CommandResult result = stage.Run();
  ASSERT_EQ(result.code, 0) << result.err;
  const LandmarkVideo video = ReadLandmarks(stage.out);
  ASSERT_EQ(video.frames.size(), 3u);
  const int values[] = {0, 0, 255};
  for (size_t f = 0; f < 3; ++f) {
    const Image8 matte = ReadImage(video.frames[f].matte);
    EXPECT_EQ(matte.at(20, 5, 0), values[f]) << f;
    EXPECT_EQ(matte.at(5, 5, 0), 0) << f;
  }
}

// Another video's, and somebody's own in a folder of a likely name.
TEST(Landmarks, LeaveOtherMattesAlone) {
  const Stage stage;
  stage.Node("[" + Stage::Face() + "," + Stage::Face() + "," + Stage::Face() + "]");
  ASSERT_EQ(stage.Run().code, 0);
  const std::string first = ReadLandmarks(stage.out).frames[0].matte;
  const std::vector<char> before = ReadFile(first);
  const std::string own = stage.folder / "out/mattes";
  MakeDirectories(own);
  Image8 matte(kSide, kSide, 1, 100);
  for (int x = 0; x < kSide; ++x) matte.at(x, 0, 0) = uint8_t(8 * x);  // as soft as a matte
  for (const char* name : {"8", "9", "10"}) WriteImage(own + "/" + name + ".png", matte);
  const std::string other = stage.folder / "out/other.json";
  ASSERT_EQ(stage.RunTo(other, {"--matte", own}).code, 0);
  const std::string second = ReadLandmarks(other).frames[0].matte;
  EXPECT_EQ(ReadImage(second).at(5, 5, 0), 100);
  EXPECT_EQ(ReadFile(first), before);
  const CommandResult onto_itself =
      stage.RunTo(other, {"--matte", std::filesystem::path(second).parent_path().string() + "/"});
  EXPECT_EQ(onto_itself.code, 2);
  EXPECT_NE(onto_itself.err.find("would be overwritten"), std::string::npos) << onto_itself.err;
}

TEST(Landmarks, TakeOwnMattes) {
  const Stage stage;
  stage.Node("[" + Stage::Face() + "," + Stage::Face() + "," + Stage::Face() + "]");
  const std::string mattes = stage.folder / "mattes";
  MakeDirectories(mattes);
  const auto write = [&](const std::string& name, int side, int value) {
    Image8 matte(side, side, 1, uint8_t(value));
    for (int x = 0; x < side; ++x) matte.at(x, 0, 0) = uint8_t(8 * x);  // as soft as a matte
    WriteImage(mattes + "/" + name + ".png", matte);
  };
  const auto refused = [&](const std::string& words) {
    const CommandResult result = stage.Run({"--matte", mattes});
    EXPECT_EQ(result.code, 2);
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_TRUE(std::filesystem::is_empty(stage.folder / "out"));
  };
  write("8", kSide, 100), write("10", kSide, 102);
  refused("has 2 mattes for 3 frames, and none for frame '9'");
  for (const char* name : {"8", "9", "10"}) write(name, kSide + 1, 0);
  refused("mattes are 33x33, the frames 32x32");
  // By name, among others; then in order.
  write("7", kSide, 99), write("8", kSide, 100), write("9", kSide, 101), write("10", kSide, 102);
  const auto expect = [&](const std::vector<int>& values) {
    const CommandResult result = stage.Run({"--matte", mattes});
    ASSERT_EQ(result.code, 0) << result.err;
    const LandmarkVideo video = ReadLandmarks(stage.out);
    for (size_t f = 0; f < 3; ++f)
      EXPECT_EQ(ReadImage(video.frames[f].matte).at(5, 5, 0), values[f]);
  };
  expect({100, 101, 102});
  std::filesystem::remove(mattes + "/8.png");
  expect({99, 101, 102});
  // A grey video, whose black stays black although it is not quite 0.
  VideoWriter writer(stage.folder / "mattes.mp4", kSide, kSide, 25);
  for (int f = 0; f < 3; ++f) writer.Write(Image8(kSide, kSide, 3, uint8_t(f == 2 ? 3 : 200)));
  writer.Finish();
  ASSERT_EQ(stage.Run({"--matte", stage.folder / "mattes.mp4"}).code, 0);
  EXPECT_NEAR(ReadImage(ReadLandmarks(stage.out).frames[1].matte).at(5, 5, 0), 200, 5);
  EXPECT_NEAR(ReadImage(ReadLandmarks(stage.out).frames[2].matte).at(5, 5, 0), 3, 5);
  const CommandResult both = Cosplat({"avatar",
                                      stage.images,
                                      "-o",
                                      stage.folder / "avatar",
                                      "--matte",
                                      mattes,
                                      "--landmarks",
                                      stage.out});
  EXPECT_EQ(both.code, 2);
  EXPECT_NE(both.err.find("--matte excludes --landmarks"), std::string::npos) << both.err;
}

TEST(Landmarks, NameWhatIsMissingOrFails) {
  const Stage stage;
  stage.Program("node", "echo 'chromium ended early (SIGSEGV): no memory' >&2; exit 3");
  stage.ExpectRefused({"landmarks", "status 3", "ended early (SIGSEGV)"});
  stage.Node("[[],[],[]]");
  stage.ExpectRefused({stage.images, "has no face"});
  stage.Node("[[]");
  stage.ExpectRefused({"faces.json", "JSON"});
  stage.Program("npm", "echo 'npm error network' >&2; exit 1");
  std::filesystem::remove_all(stage.folder / "cache");
  stage.ExpectRefused({"npm", "status 1", "network"});
  const CommandResult bare = Cosplat({"landmarks", stage.images, "-o", stage.out},
                                     "PATH='" + (stage.folder / "out") + "'");
  EXPECT_EQ(bare.code, 2);
  EXPECT_NE(bare.err.find("apt-get install nodejs npm chromium"), std::string::npos) << bare.err;
  const CommandResult nowhere = Cosplat({"landmarks", stage.folder / "no.mp4", "-o", stage.out});
  EXPECT_NE(nowhere.err.find("no.mp4"), std::string::npos) << nowhere.err;
}

// A made head is enough of a face for MediaPipe.
TEST(Landmarks, AreFoundByChromium) {
  const CommandResult programs = {
      std::system("(command -v node && command -v npm && command -v chromium) >/dev/null"), "", ""};
  if (programs.code != 0) GTEST_SKIP() << "node, npm or Chromium is not installed";
  const TemporaryFolder folder;
  ASSERT_EQ(Cosplat({"make-head",
                     "-o",
                     folder / "head",
                     "--frames",
                     "4",
                     "--test-frames",
                     "1",
                     "--size",
                     "256",
                     "--quiet"})
                .code,
            0);
  const std::string marks = folder / "marks.json";
  const CommandResult result =
      Cosplat({"landmarks", folder / "head/image", "-o", marks, "--quiet"});
  if (result.err.find("npm") != std::string::npos) GTEST_SKIP() << result.err;
  ASSERT_EQ(result.code, 0) << result.err;
  const LandmarkVideo video = ReadLandmarks(marks);
  ASSERT_EQ(video.frames.size(), 4u);
  for (const LandmarkFrame& frame : video.frames) {
    ASSERT_EQ(frame.faces.size(), 1u);
    // The tip of the nose is in the middle third of the image.
    for (int k = 0; k < 2; ++k) {
      EXPECT_GT(frame.faces[0].points[1][size_t(k)], 85);
      EXPECT_LT(frame.faces[0].points[1][size_t(k)], 175);
    }
  }
  // The points are where the head's model has them.
  const CommandResult track = Cosplat({"track",
                                       folder / "head/image",
                                       "--landmarks",
                                       marks,
                                       "-o",
                                       folder / "track",
                                       "--avatar-rounds",
                                       "0",
                                       "--quiet"});
  ASSERT_EQ(track.code, 0) << track.err;
  EXPECT_LT(ReadJson(folder / "track/track.json")["error_px"].get<double>(), 2.5);
  // The same head far away, in a corner of large frames.
  const std::string large = folder / "large";
  MakeDirectories(large);
  for (const LandmarkFrame& frame : video.frames) {
    const std::string name = "/" + frame.name + ".png";
    const Image8 head = ResizeByArea(RgbOf(ReadImage(folder / ("head/image" + name))), 90, 90);
    Image8 image(1280, 720, 3, head.at(0, 0, 0));
    for (int y = 0; y < head.height; ++y)
      for (int x = 0; x < head.width; ++x)
        for (int c = 0; c < 3; ++c) image.at(1100 + x, 560 + y, c) = head.at(x, y, c);
    WriteImage(large + name, image);
  }
  ASSERT_EQ(Cosplat({"landmarks", large, "-o", marks, "--size", "256", "--quiet"}).code, 0);
  const LandmarkVideo far = ReadLandmarks(marks);
  ASSERT_TRUE(far.crop);
  EXPECT_LT(far.crop->part.width, 150);
  for (size_t f = 0; f < 4; ++f) {
    ASSERT_EQ(far.frames[f].faces.size(), 1u);
    const auto nose = far.crop->InFrame(far.frames[f].faces[0].points[1]);
    const auto& near = video.frames[f].faces[0].points[1];
    EXPECT_NEAR(nose[0], 1100 + near[0] * 90 / 256, 3);
    EXPECT_NEAR(nose[1], 560 + near[1] * 90 / 256, 3);
  }
}

}  // namespace
}  // namespace cosplat
