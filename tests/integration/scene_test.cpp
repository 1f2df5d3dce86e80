// `cosplat scene`: with a program in COLMAP's place that does as it is told, and with COLMAP itself
// where it is installed.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

#include "splat/io/dataset.h"
#include "splat/media/webp.h"
#include "tests/integration/fake_colmap.h"

namespace cosplat::test {
namespace {

// Ends in one line with each of the parts, after at most the last lines of COLMAP, and leaves no
// result.
void ExpectError(const FakeColmap& fake,
                 const CommandResult& result,
                 const std::vector<std::string>& parts) {
  EXPECT_EQ(result.code, 2) << result.out;
  std::istringstream lines(result.err);
  std::string last;
  for (std::string line; std::getline(lines, line);) last = line;
  EXPECT_TRUE(last.starts_with("cosplat: ")) << result.err;
  for (const std::string& part : parts) EXPECT_TRUE(Contains(last, part)) << part << ": " << last;
  for (const char* name : {"data", "registration.json", "run.json", "report.html"})
    EXPECT_FALSE(fake.Has(name)) << name;
}

TEST(Scene, FromPhotographsToReportAndOrbit) {
  const FakeColmap fake;
  const CommandResult result = fake.Run();
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(Contains(result.out, "cameras of 10 of 10 photographs, 200 points")) << result.out;
  for (const char* name : {"data/images/p0.png",
                           "data/sparse/0/cameras.txt",
                           "results.json",
                           "report.html",
                           "orbit.mp4",
                           "test/ours_30/renders/00001.png"})
    EXPECT_TRUE(fake.Has(name)) << name;
  EXPECT_FALSE(fake.Has("data/stereo"));
  EXPECT_FALSE(fake.Has("colmap/undistorted"));
  const std::vector<std::string> calls = fake.TakeCalls();
  ASSERT_EQ(calls.size(), 4u);
  EXPECT_TRUE(Contains(calls[0], "feature_extractor "));
  EXPECT_TRUE(Contains(calls[0], "--ImageReader.single_camera 1 --SiftExtraction.use_gpu 0"));
  EXPECT_TRUE(Contains(calls[0], "SIMPLE_RADIAL"));
  EXPECT_TRUE(Contains(calls[1], "exhaustive_matcher "));
  EXPECT_TRUE(Contains(calls[2], "mapper "));
  EXPECT_TRUE(Contains(calls[3], "--max_image_size 1600"));
  EXPECT_TRUE(Contains(Slurp(fake.out + "/colmap/log.txt"), "Registering image #2 (3)"));
}

TEST(Scene, ItsConfigurationRepeatsIt) {
  const FakeColmap fake;
  ASSERT_EQ(fake.Run().code, 0);
  fs::remove(fake.out + "/report.html");
  const CommandResult again = Cosplat({"scene", "--config", fake.out + "/config.ini"});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_TRUE(Contains(again.out, "trained by an earlier run")) << again.out;
  EXPECT_TRUE(fake.Has("report.html"));
}

TEST(Scene, FindsAllOfTheDistortionFromManyPhotographs) {
  const FakeColmap fake;
  for (int i = kViews; i < 30; ++i)
    fs::copy_file(fake.photographs + "/p0.png", fake.photographs + "/" + NameOf(i));
  EXPECT_EQ(fake.Run({"--cameras-only"}).code, 0);
  EXPECT_TRUE(Contains(fake.TakeCalls()[0], "OPENCV"));
}

TEST(Scene, KeepsWhatIsFinished) {
  const FakeColmap fake;
  ASSERT_EQ(fake.Run().code, 0);
  fake.TakeCalls();
  const CommandResult again = fake.Run();
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_TRUE(Contains(again.out, "kept from an earlier run")) << again.out;
  EXPECT_TRUE(Contains(again.out, "trained by an earlier run")) << again.out;
  const std::string results = Slurp(fake.out + "/results.json");
  const CommandResult refused = fake.Run({"--seed", "1"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_TRUE(Contains(refused.err, "--seed 0 (now 1): --overwrite")) << refused.err;
  EXPECT_EQ(Slurp(fake.out + "/results.json"), results);
  const CommandResult other = fake.Run({"--seed", "1", "--overwrite"});
  EXPECT_TRUE(Contains(other.out, "kept from an earlier run")) << other.out;
  EXPECT_TRUE(Contains(other.out, "30 iterations in")) << other.out;
  EXPECT_TRUE(fake.TakeCalls().empty());
  WriteImage(fake.photographs + "/" + NameOf(0), Photograph(1, FakeColmap::kWidth));
  const CommandResult new_data = fake.Run({"--seed", "1"});
  EXPECT_EQ(new_data.code, 2);
  EXPECT_TRUE(Contains(new_data.err, "holds a finished run: --overwrite")) << new_data.err;
  EXPECT_TRUE(fake.TakeCalls().empty());
  EXPECT_TRUE(fake.Has("results.json"));
  const CommandResult changed = fake.Run({"--seed", "1", "--overwrite"});
  EXPECT_EQ(changed.code, 3) << changed.err;  // a test image is a training image now
  EXPECT_FALSE(Contains(changed.out, "earlier run")) << changed.out;
  EXPECT_EQ(fake.TakeCalls().size(), 4u);
}

TEST(Scene, ContinuesWhereItWasInterrupted) {
  const FakeColmap fake;
  fake.WriteProgram("[ $command = mapper ] && kill -9 $$");
  ExpectError(fake, fake.Run(), {"colmap mapper", "killed by signal 9", "colmap/log.txt"});
  fake.WriteProgram("");
  ASSERT_EQ(fake.Run({"--cameras-only"}).code, 0);
  EXPECT_EQ(Slurp(fake.out + "/colmap/database.db"), "made\nmade\n");  // the same file
  EXPECT_FALSE(fake.Has("run.json"));
}

TEST(Scene, NamesWhatIsNotRegistered) {
  const FakeColmap fake(5);
  const CommandResult result = fake.Run({"--cameras-only"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(Contains(result.out, "cameras of 5 of 10 photographs")) << result.out;
  EXPECT_TRUE(Contains(result.out, "not registered: p5.png p6.png p7.png")) << result.out;
  EXPECT_TRUE(Contains(result.err, "warning: 5 of 10 photographs have no camera")) << result.err;
  const Json json = Json::parse(Slurp(fake.out + "/registration.json"));
  EXPECT_EQ(json["not_registered"].size(), 5u);
}

TEST(Scene, TrainsOnAllWithoutEval) {
  const FakeColmap fake;
  const CommandResult result = fake.Run({"--eval=false", "--quiet"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out + result.err, "");
  EXPECT_TRUE(fake.Has("orbit.mp4"));
  EXPECT_FALSE(fake.Has("report.html"));
}

// What a wrong focal length looks like from outside.
TEST(Scene, StartsFromACloserPairWhereTheErrorIsLarge) {
  const FakeColmap fake;
  WriteModel(fake.folder / "wrong", FakeColmap::kWidth, kViews, "1.1");
  const auto wrong_where = [&](const std::string& condition) {
    fake.WriteProgram("[ $command = mapper ] && " + condition + " && { mkdir $output/0; cp '" +
                      fake.folder / "wrong" + "'/* $output/0; exit 0; }");
  };
  const std::string closer =
      "tail -n 1 '" + fake.calls + "' | grep -q -- '--Mapper.init_min_tri_angle 8'";
  wrong_where("! " + closer);
  const CommandResult mended = fake.Run({"--cameras-only"});
  EXPECT_TRUE(Contains(mended.out, "200 points with an error of 0.50 px")) << mended.out;
  EXPECT_EQ(fake.TakeCalls().size(), 5u);
  fs::remove_all(fake.out);
  wrong_where("true");
  const CommandResult still = fake.Run({"--cameras-only"});
  EXPECT_TRUE(Contains(still.out, "with an error of 1.10 px")) << still.out;
  EXPECT_EQ(still.code, 0) << still.err;
}

TEST(Scene, TakesTheSharpestFramesOfAVideo) {
  const FakeColmap fake;
  const std::string video = fake.folder / "video.mp4";
  VideoWriter writer(video, 96, 72, 25);
  for (int i = 0; i < 3 * kViews; ++i) {
    const Image8 sharp = Photograph(i / 3, 96);
    writer.Write(i % 3 == 1 ? sharp : ResizeByArea(ResizeByArea(sharp, 12, 9), 96, 72));
  }
  writer.Finish();
  ExpectError(fake,
              fake.Run({"--frames", "10", "--cameras-only"}, video),
              {"frames cannot be used"});  // the model is of photographs
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(fake.out + "/colmap/photographs"))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  ASSERT_EQ(names.size(), 10u);
  for (int i = 0; i < 10; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "frame_%06d.jpg", 3 * i + 1);
    EXPECT_EQ(names[i], name);
  }
  const std::vector<std::string> calls = fake.TakeCalls();
  EXPECT_TRUE(Contains(calls[1], "sequential_matcher ")) << calls[1];
  EXPECT_FALSE(Contains(calls[1], "quadratic_overlap")) << calls[1];
  EXPECT_TRUE(Contains(calls[2], "sequential_matcher ")) << calls[2];
  EXPECT_TRUE(Contains(calls[2], "--SequentialMatching.quadratic_overlap 0")) << calls[2];
}

// The JPEG with an EXIF segment that has nothing but an orientation.
void WriteTurned(const std::string& path, const Image8& image, char orientation) {
  const std::vector<uint8_t> jpeg = EncodeImage(path, image);
  std::string exif(
      "\xff\xe1\x00\x22"
      "Exif\0\0"
      "II*\0\x08\0\0\0"
      "\x01\0"
      "\x12\x01\x03\0",
      24);
  exif += std::string("\x01\0\0\0", 4) + orientation + std::string(7, '\0');
  exif[3] = char(exif.size() - 2);
  std::ofstream stream(path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(jpeg.data()), 2);
  stream << exif;
  stream.write(reinterpret_cast<const char*>(jpeg.data()) + 2, std::streamsize(jpeg.size()) - 2);
}

TEST(Scene, TurnsPhotographsUprightAndSeparatesLenses) {
  const FakeColmap fake;
  fs::remove(fake.photographs + "/p9.png");
  const Image8 image = Photograph(9, FakeColmap::kWidth);
  WriteTurned(fake.photographs + "/p9.jpg", image, 6);
  // A photograph in two forms counts once, and what COLMAP may not read is converted.
  std::ofstream(fake.photographs + "/p9.HEIC") << "not read";
  Image8 opaque(image.width, image.height, 4);
  std::fill(opaque.data.begin(), opaque.data.end(), uint8_t(255));
  fs::remove(fake.photographs + "/p8.png");
  std::ofstream(fake.photographs + "/p8.webp", std::ios::binary)
      << EncodeWebp("p8.webp", "image", opaque);
  fake.Run({"--matching", "sequential"});
  const Image8 turned = ReadImage(fake.out + "/colmap/photographs/2/p9.jpg");
  EXPECT_EQ(turned.width, image.height);
  EXPECT_EQ(turned.height, image.width);
  EXPECT_TRUE(fs::is_symlink(fake.out + "/colmap/photographs/1/p0.png"));
  EXPECT_EQ(ReadImage(fake.out + "/colmap/photographs/1/p8.webp.png").width, image.width);
  const std::vector<std::string> calls = fake.TakeCalls();
  EXPECT_TRUE(Contains(calls[0], "SIMPLE_RADIAL --ImageReader.single_camera_per_folder 1"));
  EXPECT_TRUE(Contains(calls[1], "sequential_matcher "));
}

TEST(Scene, SkipsDamagedPhotographs) {
  const FakeColmap fake(8);
  const std::string bytes = Slurp(fake.photographs + "/p9.png");
  std::ofstream(fake.photographs + "/p9.png", std::ios::binary) << bytes.substr(0, 500);
  const CommandResult result = fake.Run({"--cameras-only"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(Contains(result.out, "p9.png: " + fake.photographs + "/p9.png: is truncated after"))
      << result.out;
  EXPECT_TRUE(Contains(result.out, "cameras of 8 of 9 photographs")) << result.out;
}

TEST(Scene, SaysWhatIsWrongWithThePhotographs) {
  const FakeColmap fake;
  const std::string empty = fake.folder / "empty", few = fake.folder / "few";
  fs::create_directories(empty);
  ExpectError(fake, fake.Run({}, empty), {empty, "contains no photographs"});
  std::ofstream(empty + "/IMG_1.HEIC") << std::string(
      "\0\0\0\x18"
      "ftypheic\0\0\0\0mif1heic",
      24);
  ExpectError(fake, fake.Run({}, empty), {"1 of 1 frames", "IMG_1.HEIC", "convert it to JPEG"});
  WritePhotographs(few, FakeColmap::kWidth, 1);
  ExpectError(fake, fake.Run({}, few), {few, "has 1 photographs, expected at least 3"});
  for (int i = 1; i < 4; ++i) std::ofstream(few + "/" + NameOf(i)) << "no image";
  ExpectError(fake, fake.Run({}, few), {few, "3 of 4 frames cannot be used", "p1.png"});
  ExpectError(fake, fake.Run({}, fake.folder / "absent"), {"absent", "is neither a folder"});
  ExpectError(fake, fake.Run({}, fake.program), {fake.program, "video"});
  ExpectError(fake, Cosplat({"scene", few, "-o", few}), {few, "of the photographs"});
  EXPECT_TRUE(fake.TakeCalls().empty());
}

TEST(Scene, SaysHowToInstallColmap) {
  const FakeColmap fake;
  ExpectError(fake,
              Cosplat({"scene", fake.photographs, "-o", fake.out, "--colmap", "no-colmap"}),
              {"no-colmap", "apt-get install colmap"});
  EXPECT_FALSE(fs::exists(fake.out));
  fs::rename(fake.program, fake.folder / "bin/other");
  const CommandResult found =
      Cosplat({"scene", fake.photographs, "-o", fake.out, "--colmap", "other", "--cameras-only"},
              "PATH='" + fake.folder.path() + "/bin':\"$PATH\"");
  EXPECT_EQ(found.code, 0) << found.err;
}

TEST(Scene, SaysWhatColmapDied) {
  const FakeColmap fake;
  fake.WriteProgram("[ $command = feature_extractor ] && { echo 'ERROR: disk' >&2; exit 1; }");
  const CommandResult exits = fake.Run();
  ExpectError(fake, exits, {"colmap feature_extractor: exited with status 1; its log is"});
  EXPECT_TRUE(Contains(exits.err, "  ERROR: disk\n")) << exits.err;
  fake.WriteProgram("[ $command = mapper ] && { echo 'ERROR: failed to create'; exit 1; }");
  ExpectError(fake, fake.Run(), {"cameras of 0 of 10 photographs", "overlap too little"});
  fake.WriteProgram(
      "[ $command = mapper ] && { mkdir $output/0; echo x > $output/0/cameras.bin; }");
  ExpectError(fake, fake.Run(), {"cameras.bin"});
  fake.WriteProgram("[ $command = image_undistorter ] && exit 0");
  EXPECT_EQ(fake.Run().code, 2);
  EXPECT_FALSE(fake.Has("data"));
}

TEST(Scene, TwoCamerasAreTooFew) {
  const FakeColmap fake(2);
  ExpectError(fake, fake.Run(), {"cameras of 2 of 10 photographs"});
}

// COLMAP's world is ours up to a similarity: rotations between cameras agree, and distances between
// them up to one factor.
TEST(Scene, ColmapFindsTheMadeCameras) {
  if (std::system("command -v colmap >/dev/null") != 0) GTEST_SKIP() << "COLMAP is not installed";
  const TemporaryFolder folder;
  constexpr int kWidth = 400;
  WritePhotographs(folder / "photographs", kWidth);
  const CommandResult result =
      Cosplat({"scene", folder / "photographs", "-o", folder / "out", "--cameras-only"});
  ASSERT_EQ(result.code, 0) << result.err << Slurp(folder / "out/colmap/log.txt");
  const SceneData scene = LoadScene(folder / "out/data", {});
  ASSERT_EQ(scene.train.size(), size_t(kViews)) << result.out;
  const auto relative = [](const Camera& a, const Camera& b, int row, int column) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += a.rotation[3 * row + k] * b.rotation[3 * column + k];
    return sum;
  };
  const auto distance = [](const Camera& a, const Camera& b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += std::pow(a.Center()[k] - b.Center()[k], 2);
    return std::sqrt(sum);
  };
  const auto found = [&](int i) { return scene.train[i].camera; };
  const double scale =
      distance(found(0), found(kViews - 1)) / distance(CameraOf(0, kWidth), CameraOf(9, kWidth));
  for (int i = 0; i < kViews; ++i) {
    EXPECT_NEAR(found(i).fx / found(i).width, 0.9, 0.02);
    for (int j = 0; j < i; ++j) {
      const Camera a = CameraOf(i, kWidth), b = CameraOf(j, kWidth);
      for (int k = 0; k < 9; ++k)  // 0.01: half a degree
        EXPECT_NEAR(relative(found(i), found(j), k / 3, k % 3), relative(a, b, k / 3, k % 3), 0.01);
      EXPECT_NEAR(distance(found(i), found(j)) / scale, distance(a, b), 0.03);
    }
  }
}

}  // namespace
}  // namespace cosplat::test
