// `cosplat landmarks`, with programs that stand in for node, npm and Chromium, and with the real
// ones where they are installed.
#include "flame/io/landmarks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "splat/base/files.h"
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
    std::ofstream(folder / "matte", std::ios::binary) << std::string(kSide * kSide, char(200));
    Program("node",
            "while [ \"$1\" != --frames ]; do shift; done\n"
            "for i in 0 1 2; do cp '" +
                (folder / "matte") +
                "' $2/$i.matte; "
                "echo frame $((i + 1)); done\ncp '" +
                (folder / "faces.json") + "' $2/faces.json");
    std::ofstream(folder / "faces.json") << faces;
  }

  static std::string Face() {
    Json points = Json::array();
    for (int i = 0; i < 478; ++i) points.push_back({i % 30, i % 17});
    return Json::array({points}).dump();
  }

  CommandResult Run() const {
    return Cosplat({"landmarks", images, "-o", out},
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
  EXPECT_NE(result.out.find("Installing MediaPipe"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("faces in 2 of 3 frames"), std::string::npos) << result.out;
  const LandmarkVideo video = ReadLandmarks(stage.out);
  ASSERT_EQ(video.frames.size(), 3u);
  const char* const names[] = {"8", "9", "10"};  // as people count
  for (size_t f = 0; f < 3; ++f) {
    EXPECT_EQ(video.frames[f].name, names[f]);
    EXPECT_EQ(video.frames[f].faces.size(), f == 1 ? 0u : 1u);
    const Image8 matte = ReadImage(video.frames[f].matte);
    EXPECT_EQ(matte.channels, 1);
    EXPECT_EQ(matte.data[0], 200);
  }
  EXPECT_EQ(video.frames[0].faces[0].blendshapes.count("jawOpen"), 1u);
  // The packages are there now.
  stage.Program("npm", "exit 1");
  EXPECT_EQ(stage.Run().code, 0);
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
}

}  // namespace
}  // namespace cosplat
