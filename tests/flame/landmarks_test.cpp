#include "flame/io/landmarks.h"

#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "splat/base/files.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;
using LandmarkJson = nlohmann::json;

LandmarkVideo ThreeFrames(const TemporaryFolder& folder) {
  LandmarkVideo video;
  video.source = "me.mp4";
  video.source_checksum = 4'000'000'000;
  video.width = 64, video.height = 48;
  video.frames_per_second = 25;
  video.set = LandmarkSet::kIbug68;
  for (int f = 0; f < 3; ++f) {
    LandmarkFrame frame{std::to_string(10 * f), 10 * f, {}, folder / "mattes/x.png"};
    for (int face = 0; face < f; ++face) {
      DetectedFace found;
      for (int i = 0; i < 68; ++i) found.points.push_back({0.25 * i, 40.5 - face});
      found.score = 0.75;
      found.blendshapes = {{"jawOpen", 0.5f}};
      frame.faces.push_back(found);
    }
    video.frames.push_back(frame);
  }
  return video;
}

TEST(LandmarkFile, IsReadAsWritten) {
  const TemporaryFolder folder;
  const LandmarkVideo written = ThreeFrames(folder);
  WriteLandmarks(folder / "marks.json", written);
  const LandmarkVideo read = ReadLandmarks(folder / "marks.json");
  EXPECT_EQ(read.file, folder / "marks.json");
  EXPECT_EQ(read.source, "me.mp4");
  EXPECT_EQ(read.source_checksum, 4'000'000'000u);
  EXPECT_EQ(read.width, 64);
  EXPECT_EQ(read.height, 48);
  EXPECT_EQ(read.frames_per_second, 25);
  EXPECT_EQ(read.set, LandmarkSet::kIbug68);
  ASSERT_EQ(read.frames.size(), 3u);
  for (size_t f = 0; f < 3; ++f) {
    EXPECT_EQ(read.frames[f].name, written.frames[f].name);
    EXPECT_EQ(read.frames[f].frame, written.frames[f].frame);
    EXPECT_EQ(read.frames[f].matte, folder / "mattes/x.png");
    ASSERT_EQ(read.frames[f].faces.size(), f);
    for (size_t i = 0; i < f; ++i) {
      EXPECT_EQ(read.frames[f].faces[i].points, written.frames[f].faces[i].points);
      EXPECT_EQ(read.frames[f].faces[i].score, 0.75);
      EXPECT_EQ(read.frames[f].faces[i].blendshapes.at("jawOpen"), 0.5f);
    }
  }
}

TEST(LandmarkFile, KeepsCropAndTestFrames) {
  const TemporaryFolder folder;
  LandmarkVideo video = ThreeFrames(folder);
  video.width = 64, video.height = 48;
  video.crop = FrameCrop{{30, 12, 120, 90}, 640, 480, 64, 48};
  video.held_out = 1;
  const std::string path = folder / "marks.json";
  WriteLandmarks(path, video);
  const LandmarkVideo read = ReadLandmarks(path);
  ASSERT_TRUE(read.crop);
  EXPECT_EQ(read.crop->part.x, 30);
  EXPECT_EQ(read.crop->part.y, 12);
  EXPECT_EQ(read.crop->part.width, 120);
  EXPECT_EQ(read.crop->part.height, 90);
  EXPECT_EQ(read.crop->frame_width, 640);
  EXPECT_EQ(read.crop->frame_height, 480);
  EXPECT_EQ(read.crop->width, 64);
  EXPECT_EQ(read.crop->height, 48);
  EXPECT_EQ(read.held_out, 1);
  const std::vector<char> text = ReadFile(path);
  const auto damaged = [&](const char* at, int value, const std::vector<std::string>& words) {
    LandmarkJson json = LandmarkJson::parse(text.begin(), text.end());
    json[LandmarkJson::json_pointer(at)] = value;
    WriteFileAtomically(path, json.dump());
    ExpectError([&] { ReadLandmarks(path); }, words);
  };
  damaged("/crop/x", 521, {path, "crop.x", "521"});
  damaged("/crop/y", -1, {"crop.y", "-1"});
  damaged("/crop/height", 481, {"crop.height", "481"});
  damaged("/crop/width", 60, {"crop.width", "60x90", "64x48"});
  damaged("/height", 50, {"crop.width", "120x90", "64x50"});
  damaged("/held_out", 4, {"held_out", "4"});
}

// As older files have it.
TEST(LandmarkFile, ReadsASquareByItsSide) {
  const TemporaryFolder folder;
  LandmarkVideo video = ThreeFrames(folder);
  video.width = video.height = 64;
  video.crop = FrameCrop{{30, 12, 90, 90}, 640, 480, 64, 64};
  const std::string path = folder / "marks.json";
  WriteLandmarks(path, video);
  const std::vector<char> text = ReadFile(path);
  LandmarkJson json = LandmarkJson::parse(text.begin(), text.end());
  json["crop"].erase("width"), json["crop"].erase("height");
  json["crop"]["side"] = 90;
  WriteFileAtomically(path, json.dump());
  const LandmarkVideo read = ReadLandmarks(path);
  ASSERT_TRUE(read.crop);
  EXPECT_EQ(read.crop->part.width, 90);
  EXPECT_EQ(read.crop->part.height, 90);
  json["crop"]["side"] = 60;
  WriteFileAtomically(path, json.dump());
  ExpectError([&] { ReadLandmarks(path); }, {"crop.side", "60", "64x64"});
}

// Each damage costs one line that names file, field and value.
TEST(LandmarkFile, NamesWhatIsDamaged) {
  const TemporaryFolder folder;
  const std::string path = folder / "marks.json";
  WriteLandmarks(path, ThreeFrames(folder));
  const std::vector<char> text = ReadFile(path);
  const auto damaged = [&](const std::function<void(LandmarkJson&)>& damage,
                           const std::vector<std::string>& words) {
    LandmarkJson json = LandmarkJson::parse(text.begin(), text.end());
    damage(json);
    WriteFileAtomically(path, json.dump());
    ExpectError([&] { ReadLandmarks(path); }, words);
  };
  using J = LandmarkJson;
  damaged([](J& j) { j["format"] = "x"; }, {path, "format", "'x'"});
  damaged([](J& j) { j["version"] = 2; }, {"version", "2"});
  damaged([](J& j) { j["source_checksum"] = 1e10; }, {"source_checksum", "10000000000, expected"});
  damaged([](J& j) { j["width"] = 0; }, {"width", "0"});
  damaged([](J& j) { j["frames_per_second"] = -1; }, {"frames_per_second", "-1"});
  damaged([](J& j) { j["landmarks"] = "dlib-5"; }, {"landmarks", "dlib-5", "ibug-68"});
  damaged([](J& j) { j["frames"][2]["frame"] = 10; }, {"frames[2].frame", "10", "11"});
  damaged([](J& j) { j["frames"][1].erase("faces"); }, {"frames[1]", "faces"});
  J::json_pointer face("/frames/1/faces/0");
  damaged([&](J& j) { j[face]["points"].erase(3); }, {"faces[0].points", "67", "68 of ibug-68"});
  damaged([&](J& j) { j[face]["points"][3] = {1}; }, {"points[3]", "1 numbers"});
  damaged([&](J& j) { j[face]["points"][3][1] = nullptr; }, {"points[3][1]"});
  damaged([&](J& j) { j[face]["points"][3][1] = 1e4; }, {"points[3]", "10000", "48 px"});
  damaged([&](J& j) { j[face]["score"] = 1.5; }, {"score", "1.5"});
  damaged([&](J& j) { j[face]["blendshapes"] = 3; }, {"blendshapes"});
  damaged([&](J& j) { j[face]["blendshapes"]["jawOpen"] = -2; }, {"blendshapes.jawOpen", "-2"});
  WriteFileAtomically(path, "{");
  ExpectError([&] { ReadLandmarks(path); }, {path});
}

// tests/golden/landmarks_v1.json, which docs/landmarks.md describes, must stay readable.
TEST(LandmarkFile, GoldenFileOfVersionOne) {
  const LandmarkVideo video = ReadLandmarks(COSPLAT_SOURCE_DIR "/tests/golden/landmarks_v1.json");
  EXPECT_EQ(video.set, LandmarkSet::kOther);
  EXPECT_EQ(video.width, 64);
  ASSERT_EQ(video.frames.size(), 2u);
  EXPECT_TRUE(video.frames[0].faces.empty());
  ASSERT_EQ(video.frames[1].faces.size(), 1u);
  const DetectedFace& face = video.frames[1].faces[0];
  EXPECT_EQ(face.points[1], (std::array<double, 2>{3.5, 4}));
  EXPECT_EQ(face.score, 0.75);
  EXPECT_EQ(face.blendshapes.at("jawOpen"), 0.5f);
}

}  // namespace
}  // namespace cosplat
