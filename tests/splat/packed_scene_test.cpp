// Scenes in one file for bare machines (tests/gpu/packed_scene.h): the same bytes, the same
// training.
#include "tests/gpu/packed_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include "apps/cosplat/run/scene_start.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ReadPackedScene;
using test::TemporaryFolder;

// Blender's layout: three training views and a test view, 24 pixels a side.
void WriteScene(const TemporaryFolder& folder) {
  const std::vector<TrainFrame> frames =
      test::TargetImages(test::TrueScene(1, 20), test::Ring(4, 2.2f, 24), true);
  for (const std::string split : {"train", "test"}) {
    MakeDirectories(folder / split);
    Json json{{"camera_angle_x", 2 * std::atan(12 / frames[0].camera.fx)},
              {"frames", Json::array()}};
    for (size_t i = 0; i < frames.size(); ++i) {
      if ((split == "test") != (i == 3)) continue;
      const Camera& camera = frames[i].camera;
      const std::string name = split + "/" + std::to_string(i);
      WriteImage(folder / (name + ".png"), frames[i].target);
      Json matrix = Json::array();
      for (int r = 0; r < 3; ++r)
        matrix.push_back({camera.rotation[r],
                          -camera.rotation[3 + r],
                          -camera.rotation[6 + r],
                          camera.Center()[r]});
      matrix.push_back({0, 0, 0, 1});
      json["frames"].push_back({{"file_path", name}, {"transform_matrix", matrix}});
    }
    WriteFileAtomically(folder / ("transforms_" + split + ".json"), json.dump());
  }
}

std::string Packed(const TrainingScene& scene) {
  std::ostringstream out;
  test::WritePackedScene(out, scene);
  return out.str();
}

TrainingScene Unpacked(const std::string& bytes) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "scene", bytes);
  return ReadPackedScene(folder / "scene");
}

// RGB and RGBA of noise, of sizes that are no multiples of anything, and points.
TrainingScene NoisyScene() {
  Rng rng{4};
  TrainingScene scene;
  for (const int channels : {3, 4, 3}) {
    TrainFrame frame;
    frame.camera = test::Ring(4, 2.0f + float(channels), 16)[1].Resized(7 + channels, 5);
    frame.target = Image8(frame.camera.width, frame.camera.height, channels);
    for (uint8_t& byte : frame.target.data) byte = uint8_t(rng.Below(256));
    scene.train.push_back(std::move(frame));
  }
  scene.test = {scene.train.back()};
  scene.train.pop_back();
  scene.points = {0, 1, 2, -3, 4, 1e-9f};
  scene.point_colors = {0, 127, 255, 1, 2, 3};
  scene.extent = 2.25f;
  scene.renderings = true;
  return scene;
}

void ExpectSame(const std::vector<TrainFrame>& a, const std::vector<TrainFrame>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(std::memcmp(&a[i].camera, &b[i].camera, sizeof(Camera)), 0) << i;
    EXPECT_EQ(a[i].target.channels, b[i].target.channels);
    EXPECT_EQ(a[i].target.data, b[i].target.data) << i;
  }
}

TEST(PackedScene, KeepsEveryByte) {
  const TrainingScene scene = NoisyScene(), read = Unpacked(Packed(scene));
  ExpectSame(scene.train, read.train);
  ExpectSame(scene.test, read.test);
  EXPECT_EQ(scene.points, read.points);
  EXPECT_EQ(scene.point_colors, read.point_colors);
  EXPECT_EQ(scene.extent, read.extent);
  EXPECT_EQ(scene.renderings, read.renderings);
}

// Without points: they are drawn at random, by the cameras.
TEST(PackedScene, TrainsAsFromItsFolder) {
  const TemporaryFolder folder;
  WriteScene(folder);
  SceneData data = LoadScene(folder.path(), {.eval = true});
  const TrainingScene loaded = LoadTrainingScene(data);
  ASSERT_EQ(loaded.train.size(), 3u);
  ASSERT_EQ(loaded.test.size(), 1u);
  std::vector<Gaussians> ends;
  for (TrainingScene scene : {loaded, Unpacked(Packed(loaded))}) {
    TrainOptions choices;
    choices.iterations = 40;
    SceneStart start = StartScene(200, choices, scene);
    EXPECT_EQ(start.settings.background, Background::kWhite);
    EXPECT_EQ(start.settings.schedule.opacity_reset_share, 1)
        << "random points need resets throughout";
    SceneSubject subject(scene.train, scene.extent);
    Trainer trainer(start.settings, subject, std::move(start.first));
    while (trainer.iteration() < choices.iterations) trainer.Step();
    ends.push_back(trainer.state().gaussians);
  }
  for (int a = 0; a < kAttributeCount; ++a) EXPECT_EQ(ends[0].values[a], ends[1].values[a]) << a;
}

TEST(PackedScene, RefusesWhatIsCut) {
  const std::string bytes = Packed(NoisyScene());
  const TemporaryFolder folder;
  const std::string path = folder / "cut";
  for (size_t size = 0; size < bytes.size(); size += 7) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(size));
    test::ExpectError([&] { ReadPackedScene(path); }, {path});
  }
  test::ExpectError([&] { Unpacked(bytes + "x"); }, {"images", "bytes are left"});
}

TEST(PackedScene, NamesWhatIsWrong) {
  test::ExpectError([&] { ReadPackedScene("/nowhere/scene"); }, {"/nowhere/scene", "read"});
  test::ExpectError([&] { Unpacked(std::string(1000, 'x')); }, {"no packed scene"});
  const auto expect = [](const std::function<void(TrainingScene&)>& spoil,
                         const std::vector<std::string>& parts) {
    TrainingScene scene = NoisyScene();
    spoil(scene);
    test::ExpectError([&] { Unpacked(Packed(scene)); }, parts);
  };
  expect([](TrainingScene& s) { s.train.clear(); }, {"training views", "none"});
  expect([](TrainingScene& s) { s.extent = -1; }, {"extent", "-1"});
  expect([](TrainingScene& s) { s.extent = NAN; }, {"extent"});
  expect([](TrainingScene& s) { s.train[1].camera.fx = 0; }, {"view 1", "focal"});
  expect([](TrainingScene& s) { s.test[0].camera.translation[2] = INFINITY; },
         {"view 2", "finite"});
  expect([](TrainingScene& s) { s.train[0].camera.width = 0; }, {"view 0", "0x5x3"});
  expect([](TrainingScene& s) { s.train[0].camera.height = 9; }, {"images", "expected"});
}

}  // namespace
}  // namespace cosplat
