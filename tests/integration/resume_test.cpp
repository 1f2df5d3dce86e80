// A run that is interrupted by a signal goes on; what it may not go on with is named; and nothing
// that a folder holds is replaced unless that was asked for.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/integration/background_command.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

bool Mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::vector<std::string> With(std::vector<std::string> arguments,
                              const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

class Resume : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string out_ = folder_ / "out", photos_ = folder_ / "photos", log_ = folder_ / "log";

  void SetUp() override { fs::copy(Workshop::Get().photos, photos_, fs::copy_options::recursive); }

  std::vector<std::string> Scene(const std::string& steps, const std::string& out) const {
    return {"train-scene",
            "-s",
            photos_,
            "-m",
            out,
            "--iterations",
            steps,
            "--eval",
            "--quiet",
            "--random-points",
            "300"};
  }

  // Until it has written a checkpoint, then sends the signal; expects that it says how to go on.
  void Interrupt(const std::vector<std::string>& arguments, int signal) {
    const std::string checkpoint = out_ + "/checkpoint.bin";
    const auto written = [&] {
      std::error_code missing;
      return fs::last_write_time(checkpoint, missing);
    };
    const auto before = written();
    BackgroundCommand run(With(arguments, {"--checkpoint-every", "0.0003"}), log_);
    while (written() == before) ASSERT_FALSE(run.EndsWithin(0.01)) << Slurp(log_);
    run.Signal(signal);
    ASSERT_TRUE(run.EndsWithin(60));
    EXPECT_EQ(run.status(), 128 + signal);
    const std::string said = Slurp(log_);
    EXPECT_TRUE(Mentions(said, "cosplat: stopped at step ")) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
  }

  // One line with all of these, and nothing is changed.
  void ExpectRefused(const std::vector<std::string>& arguments,
                     const std::vector<std::string>& parts) {
    const std::string before = Slurp(out_ + "/checkpoint.bin") + Slurp(out_ + "/results.json");
    const CommandResult result = Cosplat(arguments);
    EXPECT_EQ(result.code, 2) << result.out;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    for (const std::string& part : parts)
      EXPECT_TRUE(Mentions(result.err, part)) << part << ": " << result.err;
    EXPECT_EQ(Slurp(out_ + "/checkpoint.bin") + Slurp(out_ + "/results.json"), before);
  }
};

TEST_F(Resume, AfterCtrlCAndSigtermARunHasTheBytesOfAnUndisturbedOne) {
  const std::string whole = folder_ / "whole";
  ASSERT_EQ(Cosplat(Scene("3000", whole)).code, 0);
  Interrupt(Scene("3000", out_), SIGINT);
  if (HasFatalFailure()) return;
  Interrupt(With(Scene("3000", out_), {"--resume"}), SIGTERM);
  if (HasFatalFailure()) return;
  const CommandResult result = Cosplat(With(Scene("3000", out_), {"--resume"}));
  ASSERT_EQ(result.code, 0) << result.err;
  for (const char* file :
       {"/results.json", "/per_view.json", "/point_cloud/iteration_3000/point_cloud.ply"})
    EXPECT_EQ(Slurp(out_ + file), Slurp(whole + file)) << file;
  EXPECT_FALSE(fs::exists(out_ + "/checkpoint.bin"));
}

TEST_F(Resume, OnlyWithTheSameOptionsVersionAndData) {
  const auto scene = Scene("100000", out_);
  Interrupt(scene, SIGINT);
  if (HasFatalFailure()) return;
  ExpectRefused(scene, {out_, "an interrupted run, at step ", "--resume goes on", "--overwrite"});
  ExpectRefused(With(scene, {"--resume", "--seed", "7"}), {"--seed 0 (now 7)", "--overwrite"});
  ExpectRefused(With(scene, {"--seed", "7"}), {"--seed 0 (now 7)", "--overwrite"});
  ExpectRefused(With(scene, {"--resume", "--feature_lr", "0.5"}), {"--feature_lr none (now 0.5)"});
  ExpectRefused(With(scene, {"--resume", "--prune", "lp"}), {"--prune \"none\" (now \"lp\")"});
  // The image of one view; its name is in the message.
  const std::string image = photos_ + "/train/r_2.png", bytes = Slurp(image);
  fs::copy_file(photos_ + "/train/r_3.png", image, fs::copy_options::overwrite_existing);
  ExpectRefused(With(scene, {"--resume"}), {"other data", "training view", "r_2"});
  std::ofstream(image, std::ios::binary) << bytes;
  // Damage.
  const std::string checkpoint = out_ + "/checkpoint.bin", good = Slurp(checkpoint);
  std::string damaged = good;
  damaged[damaged.size() / 2] = char(damaged[damaged.size() / 2] ^ 4);
  std::ofstream(checkpoint, std::ios::binary) << damaged;
  ExpectRefused(With(scene, {"--resume"}), {checkpoint, "damaged", "--overwrite"});
  // Another version of the program, with the right checksum, is beyond this test; another format of
  // the file is damage until its checksum is right. What may change: paths, threads, milestones.
  std::ofstream(checkpoint, std::ios::binary) << good;
  fs::rename(photos_, folder_ / "moved");
  fs::rename(out_, folder_ / "renamed");
  photos_ = folder_ / "moved";
  out_ = folder_ / "renamed";
  Interrupt(
      With(Scene("100000", out_), {"--resume", "--threads", "1", "--save_iterations", "99000"}),
      SIGTERM);
}

TEST_F(Resume, AFinishedRunIsKept) {
  const auto scene = Scene("40", out_);
  ASSERT_EQ(Cosplat(scene).code, 0);
  ExpectRefused(scene, {out_, "holds a finished run: --overwrite replaces it"});
  ExpectRefused(With(scene, {"--resume", "--iterations", "50"}), {"--iterations"});
  const std::string results = Slurp(out_ + "/results.json");
  EXPECT_EQ(Cosplat(With(scene, {"--resume"})).code, 0);
  EXPECT_EQ(Slurp(out_ + "/results.json"), results);
  std::ofstream(out_ + "/notes.txt") << "mine";
  auto longer = Scene("50", out_);
  const CommandResult result = Cosplat(With(longer, {"--overwrite"}));
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(Slurp(out_ + "/notes.txt"), "mine");
  EXPECT_FALSE(fs::exists(out_ + "/point_cloud/iteration_40"));
  EXPECT_FALSE(fs::exists(out_ + "/test/ours_40"));
  EXPECT_TRUE(fs::exists(out_ + "/test/ours_50"));
}

// Its options are the same, and its folder of data may have moved; what is in there is not.
TEST_F(Resume, AFinishedRunIsOfItsData) {
  const auto scene = [&] { return With(Scene("40", out_), {"--resume"}); };
  ASSERT_EQ(Cosplat(scene()).code, 0);
  fs::rename(photos_, folder_ / "moved");
  ExpectRefused(scene(), {photos_, "is not a folder"});
  photos_ = folder_ / "moved";
  EXPECT_EQ(Cosplat(scene()).code, 0);
  const std::string cameras = photos_ + "/transforms_train.json", good = Slurp(cameras);
  Json json = ReadJson(cameras);
  json["frames"][2]["transform_matrix"][0][3] = 3;
  std::ofstream(cameras) << json.dump();
  ExpectRefused(scene(), {"train/r_2.png", "has another camera", "--overwrite"});
  std::ofstream(cameras) << good;
  json = ReadJson(photos_ + "/transforms_test.json");
  json["frames"].erase(3);
  std::ofstream(photos_ + "/transforms_test.json") << json.dump();
  ExpectRefused(scene(), {"test/r_3.png", "is no held-out view any more", "--overwrite"});
}

TEST(ResumeAvatar, AFinishedRunIsOfItsTrack) {
  const TemporaryFolder folder;
  ASSERT_EQ(MakeSmallAvatar(folder), "");
  const auto resume = [&] {
    return Cosplat({"train-avatar",
                    "-s",
                    folder / "head",
                    "--flame",
                    folder / "head/model.npz",
                    "-m",
                    folder / "out",
                    "--iterations",
                    "4",
                    "--gaussians",
                    "500",
                    "--resume"});
  };
  EXPECT_EQ(resume().code, 0) << resume().err;
  const std::string track = folder / "head/flame_params.json";
  Json json = ReadJson(track);
  json["frames"][1]["expression"][0] = 0.5;
  std::ofstream(track) << json.dump();
  const CommandResult other = resume();
  EXPECT_EQ(other.code, 2);
  EXPECT_TRUE(Mentions(other.err, "a finished run on another track")) << other.err;
}

// Figures of other views than those that were held out would not be the run's.
TEST_F(Resume, NeitherIsAnEvaluationOfOtherData) {
  ASSERT_EQ(Cosplat(Scene("40", out_)).code, 0);
  const auto render = [&] { return std::vector<std::string>{"render", "-m", out_, "--quiet"}; };
  EXPECT_EQ(Cosplat(render()).code, 0);
  fs::remove(out_ + "/test/ours_40/renders/00003.png");
  ExpectRefused({"metrics", "-m", out_}, {"renders/00003.png", "is missing"});
  WriteImage(out_ + "/test/ours_40/renders/00003.png", Image8(8, 8, 3));
  ExpectRefused({"metrics", "-m", out_}, {"renders/00003.png: is 8x8, that in gt/ 32x32"});
  EXPECT_EQ(Cosplat(render()).code, 0);
  fs::copy_file(photos_ + "/transforms_train.json",
                photos_ + "/transforms_test.json",
                fs::copy_options::overwrite_existing);
  ExpectRefused(render(), {"is no held-out view any more"});
  EXPECT_EQ(Cosplat(With(render(), {"-o", folder_ / "frames"})).code, 0);
  EXPECT_EQ(Cosplat(With(render(), {"-o", folder_ / "frames"})).code, 0);
}

TEST_F(Resume, ResultsDoNotGoIntoTheData) {
  ExpectRefused(Scene("40", photos_), {"-m " + photos_, "is the folder of the data"});
  ExpectRefused(Scene("40", photos_ + "/train"), {"is a folder of images of the data"});
  out_ = photos_ + "/out";
  EXPECT_EQ(Cosplat(Scene("40", out_)).code, 0);
  EXPECT_EQ(Cosplat(With(Scene("40", out_), {"--overwrite"})).code, 0);
  ExpectRefused({"render", "-m", out_, "-o", photos_ + "/test"}, {"-o", "of the data"});
}

TEST_F(Resume, WithoutACheckpointARunBegins) {
  const CommandResult result = Cosplat(With(Scene("40", out_), {"--resume"}));
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(fs::exists(out_ + "/results.json"));
}

TEST_F(Resume, BothWaysAtOnceAreAnError) {
  const CommandResult result = Cosplat(With(Scene("40", out_), {"--resume", "--overwrite"}));
  EXPECT_EQ(result.code, 2);
  EXPECT_FALSE(fs::exists(out_));
}

}  // namespace
}  // namespace cosplat::test
