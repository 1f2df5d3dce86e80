// train-scene on several ranks: the same bytes on 1, 2 and 4, in one piece and in blocks; a rank
// that dies ends the run with a line on every other; a run goes on with another number of ranks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "splat/base/rng.h"
#include "splat/io/ply.h"
#include "splat/train/ranks/view_exchange.h"
#include "tests/integration/background_command.h"
#include "tests/support/rank_traffic.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

constexpr double kPatience = 300;  // seconds

// The processes of the ranks: children of mpirun that run `cosplat`.
std::vector<pid_t> RanksOf(pid_t mpirun) {
  std::vector<pid_t> ranks;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string stat = Slurp(entry.path() / "stat");
    const size_t name = stat.find("(cosplat) ");
    if (name == std::string::npos) continue;
    std::istringstream rest(stat.substr(name + 10));
    char state = 0;
    pid_t parent = 0;
    rest >> state >> parent;
    if (parent == mpirun) ranks.push_back(pid_t(std::stoi(entry.path().filename())));
  }
  std::sort(ranks.begin(), ranks.end());
  return ranks;
}

void WaitForFile(const std::string& path) {
  for (const double end = Seconds() + kPatience; !fs::exists(path) && Seconds() < end;)
    usleep(1000);
  ASSERT_TRUE(fs::exists(path)) << path;
}

class RanksTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::string(COSPLAT_MPIRUN).empty())
      GTEST_SKIP() << "mpirun is not there, or this program was built without MPI";
    WriteBallScene(photos_, 6);
  }
  std::string Out(const std::string& name) const { return folder_ / name; }

  std::vector<std::string> TrainInto(const std::string& out, int iterations, int batch = 4) const {
    return {"train-scene",
            "-s",
            photos_,
            "-m",
            out,
            "--eval",
            "--random-points",
            "3000",
            "--iterations",
            std::to_string(iterations),
            "--batch",
            std::to_string(batch)};
  }
  // The same of the two places, whose points are in a file.
  std::vector<std::string> InPlaces(std::vector<std::string> command) const {
    command[2] = Out("places");
    command.erase(command.begin() + 6, command.begin() + 8);
    return command;
  }
  // The two places in a block each.
  std::vector<std::string> InBlocks(const std::string& out, int iterations, int batch) const {
    std::vector<std::string> command = InPlaces(TrainInto(out, iterations, batch));
    command.insert(command.end(), {"--blocks", "2"});
    return command;
  }
  // mpirun's arguments, to run as root, with more ranks than cores, and on a busy machine: a rank
  // has five seconds, not one, to say that another has ended.
  static std::vector<std::string> Mpirun(size_t ranks, const std::vector<std::string>& command) {
    std::vector<std::string> line{"--allow-run-as-root",
                                  "--oversubscribe",
                                  "--tag-output",
                                  "--mca",
                                  "odls_base_sigkill_timeout",
                                  "5"};
    line.insert(line.end(), {"-n", std::to_string(ranks), COSPLAT_COMMAND});
    line.insert(line.end(), command.begin(), command.end());
    line.insert(line.end(), {"--threads", "1"});
    return line;
  }
  struct Ended {
    int status;
    std::string log;
  };
  Ended Run(size_t ranks,
            const std::vector<std::string>& command,
            const std::vector<std::string>& environment = {}) const {
    BackgroundCommand run(Mpirun(ranks, command), Out("log"), environment, COSPLAT_MPIRUN);
    EXPECT_TRUE(run.EndsWithin(kPatience));
    return {run.status(), Slurp(Out("log"))};
  }
  // Runs it until the file is there, and sends the signal to the second of the ranks.
  void SignalTheSecondOf(size_t count,
                         const std::vector<std::string>& command,
                         int signal,
                         const std::string& once_there) const {
    BackgroundCommand run(Mpirun(count, command), Out("log"), {}, COSPLAT_MPIRUN);
    WaitForFile(once_there);
    const std::vector<pid_t> ranks = RanksOf(run.pid());
    ASSERT_EQ(ranks.size(), count);
    kill(ranks[1], signal);
    ASSERT_TRUE(run.EndsWithin(kPatience));
    EXPECT_NE(run.status(), 0);
  }
  static std::string Splats(const std::string& out, int iterations) {
    return Slurp(out + "/point_cloud/iteration_" + std::to_string(iterations) + "/point_cloud.ply");
  }
  // What these ranks printed as errors; mpirun marks their lines by [1,rank]<stderr>.
  static std::vector<std::string> ErrorsIn(const std::string& log) {
    std::vector<std::string> lines;
    std::istringstream stream(log);
    for (std::string line; std::getline(stream, line);)
      for (const char* mark : {">:cosplat: ", ">: cosplat: "})  // Open MPI 4, 5
        if (line.find(mark) != std::string::npos) lines.push_back(line);
    return lines;
  }

  TemporaryFolder folder_;
  std::string photos_ = folder_ / "photos";
};

// Exit code of training on the two places, since all images of one are the same.
constexpr int kWrong = 3;

// Two discs far from each other, each with views that show it alone, so that blocks of them are
// trained at the same time.
void WriteTwoPlaces(const std::string& folder) {
  constexpr int kSide = 32, kViews = 4;
  constexpr double kAngle = 0.7, kDistance = 1;
  for (const std::string split : {"train", "test"}) {
    fs::create_directories(folder + "/" + split);
    Json frames = Json::array();
    for (int i = 0; i < 2 * kViews; ++i) {
      const double place = i < kViews ? -2 : 2;
      const double a = 0.1 * (i % kViews) + (split == "test" ? 0.05 : 0);
      const double c = std::cos(a), s = std::sin(a);
      const std::string name = split + "/r_" + std::to_string(i);
      frames.push_back({{"file_path", "./" + name},
                        {"transform_matrix",
                         {{c, 0, s, place + kDistance * s},
                          {0, 1, 0, 0},
                          {-s, 0, c, kDistance * c},
                          {0, 0, 0, 1}}}});
      Image8 image(kSide, kSide, 4);
      for (int row = 0; row < kSide; ++row)
        for (int column = 0; column < kSide; ++column) {
          const double x = column + 0.5 - kSide / 2.0, y = row + 0.5 - kSide / 2.0;
          if (std::hypot(x, y) > 10) continue;
          image.at(column, row, i < kViews ? 0 : 2) = 220;
          image.at(column, row, 3) = 255;
        }
      WriteImage(folder + "/" + name + ".png", image);
    }
    std::ofstream(folder + "/transforms_" + split + ".json")
        << Json{{"camera_angle_x", kAngle}, {"ply_file_path", "points.ply"}, {"frames", frames}};
  }
  Rng rng{1};
  std::vector<float> points;
  for (int i = 0; i < 1200; ++i)
    for (int k = 0; k < 3; ++k)
      points.push_back((k > 0 ? 0 : i % 2 == 0 ? -2.0f : 2.0f) + 0.1f * rng.Normal());
  WritePointsPly(folder + "/points.ply", points, std::vector<uint8_t>(points.size(), 128));
}

TEST_F(RanksTest, LeaveTheSameBytesOnOneTwoAndFour) {
  constexpr int kIterations = 240;
  const CommandResult alone = Cosplat(TrainInto(Out("alone"), kIterations));
  ASSERT_EQ(alone.code, 0) << alone.err;
  const std::string expected = Splats(Out("alone"), kIterations);
  ASSERT_FALSE(expected.empty());
  for (const size_t ranks : {1, 2, 4}) {
    const std::string out = Out("on" + std::to_string(ranks));
    const Ended run = Run(ranks, TrainInto(out, kIterations));
    ASSERT_EQ(run.status, 0) << run.log;
    EXPECT_TRUE(Splats(out, kIterations) == expected) << ranks << " ranks";
    EXPECT_EQ(Slurp(out + "/per_view.json"), Slurp(Out("alone") + "/per_view.json"));
    EXPECT_FALSE(fs::exists(out + "/checkpoint.bin"));
    // What was sent is as calculated, within 5 %: a rank owns about its share of what a view draws.
    const Json sent = Json::parse(Slurp(out + "/stats.json"))["batch"];
    EXPECT_EQ(sent["ranks"], ranks);
    ExchangeStatistics counts;
    counts.ranks = ranks;
    counts.views = sent["views"];
    counts.groups_drawn = sent["groups_drawn"];
    counts.assembled = sent["numbers_assembled"];
    counts.handed_over = sent["numbers_handed_over"];
    const double calculated = TrafficOf(counts);
    EXPECT_NEAR(double(sent["bytes_sent"]), calculated, 0.05 * calculated) << ranks << " ranks";
  }
}

TEST_F(RanksTest, EndWithALineWhenOneIsKilledAndResumeOnAnotherNumber) {
  constexpr int kIterations = 2000;
  ASSERT_EQ(Cosplat(TrainInto(Out("undisturbed"), kIterations)).code, 0);
  std::vector<std::string> command = TrainInto(Out("killed"), kIterations);
  command.insert(command.end(), {"--checkpoint-every", "0.005"});
  SignalTheSecondOf(4, command, SIGKILL, Out("killed") + "/checkpoint.bin");
  const std::vector<std::string> errors = ErrorsIn(Slurp(Out("log")));
  EXPECT_EQ(errors.size(), 3u) << Slurp(Out("log"));
  for (const std::string& line : errors)
    EXPECT_NE(line.find("has ended"), std::string::npos) << line;
  command.push_back("--resume");
  const Ended resumed = Run(2, command);
  ASSERT_EQ(resumed.status, 0) << resumed.log;
  EXPECT_NE(resumed.log.find("resumed at step"), std::string::npos) << resumed.log;
  EXPECT_TRUE(Splats(Out("killed"), kIterations) == Splats(Out("undisturbed"), kIterations));
}

TEST_F(RanksTest, StopTogetherWhenOneIsAskedTo) {
  constexpr int kIterations = 1600;
  const std::vector<std::string> command = TrainInto(Out("stopped"), kIterations);
  std::vector<std::string> first = command;
  first.insert(first.end(), {"--checkpoint-every", "0.005"});
  SignalTheSecondOf(2, first, SIGTERM, Out("stopped") + "/checkpoint.bin");
  const std::vector<std::string> errors = ErrorsIn(Slurp(Out("log")));
  ASSERT_EQ(errors.size(), 1u) << Slurp(Out("log"));
  EXPECT_NE(errors[0].find("--resume goes on"), std::string::npos) << errors[0];
  std::vector<std::string> again = command;
  again.push_back("--resume");
  ASSERT_EQ(Cosplat(again).code, 0);  // without mpirun
  ASSERT_EQ(Cosplat(TrainInto(Out("undisturbed"), kIterations)).code, 0);
  EXPECT_TRUE(Splats(Out("stopped"), kIterations) == Splats(Out("undisturbed"), kIterations));
}

// What the others have for a checkpoint is exchanged whether the first can write it or not.
TEST_F(RanksTest, GoOnWhereNoCheckpointCanBeWritten) {
  if (std::string(COSPLAT_FAULTS).empty()) GTEST_SKIP() << "a sanitizer interposes the same calls";
  constexpr int kIterations = 240;
  ASSERT_EQ(Cosplat(TrainInto(Out("undisturbed"), kIterations)).code, 0);
  const std::pair<const char*, const char*> faults[] = {{"full", "No space left"},
                                                        {"sync-error", "Input/output error"}};
  for (const auto& [fault, reason] : faults) {
    std::vector<std::string> command = TrainInto(Out(fault), kIterations);
    command.insert(command.end(), {"--checkpoint-every", "0.0001"});
    const Ended run = Run(3,
                          command,
                          {std::string("LD_PRELOAD=") + COSPLAT_FAULTS,
                           std::string("COSPLAT_FAULT=") + fault + ":checkpoint.bin"});
    ASSERT_EQ(run.status, 0) << run.log;
    EXPECT_NE(run.log.find("warning: no checkpoint: "), std::string::npos) << run.log;
    EXPECT_NE(run.log.find(reason), std::string::npos) << run.log;
    EXPECT_TRUE(Splats(Out(fault), kIterations) == Splats(Out("undisturbed"), kIterations));
  }
}

TEST_F(RanksTest, SayOnceWhatIsWrongWithTheInput) {
  std::vector<std::string> command = TrainInto(Out("few"), 100, 1);
  Ended run = Run(2, command);
  EXPECT_NE(run.status, 0);
  std::vector<std::string> errors = ErrorsIn(run.log);
  ASSERT_EQ(errors.size(), 1u) << run.log;
  EXPECT_NE(errors[0].find("--batch 1"), std::string::npos) << errors[0];
  EXPECT_FALSE(fs::exists(Out("few")));
  command = TrainInto(Out("none"), 100);
  command[2] = Out("nowhere");
  run = Run(2, command);
  errors = ErrorsIn(run.log);
  ASSERT_EQ(errors.size(), 1u) << run.log;
  EXPECT_NE(errors[0].find("nowhere"), std::string::npos) << errors[0];
}

// A group of ranks per block, whether views show one block each or all: of three ranks two share
// one block, one has the other.
TEST_F(RanksTest, TrainBlocksInGroups) {
  constexpr int kIterations = 400;
  WriteTwoPlaces(Out("places"));
  const auto in_blocks = [&](const std::string& out, bool apart) {
    std::vector<std::string> command = TrainInto(out, kIterations, 2);
    if (apart) command = InPlaces(command);
    command.insert(command.end(), {"--blocks", "2", "--exposure"});
    return command;
  };
  for (const bool apart : {true, false}) {
    const std::string alone = Out(apart ? "alone" : "together");
    const CommandResult by_one = Cosplat(in_blocks(alone, apart));
    const int code = apart ? kWrong : 0;
    ASSERT_EQ(by_one.code, code) << by_one.err;
    const std::string expected = Splats(alone, kIterations);
    ASSERT_FALSE(expected.empty());
    for (const size_t ranks : {2, 3}) {
      const std::string out = alone + std::to_string(ranks);
      const Ended run = Run(ranks, in_blocks(out, apart));
      ASSERT_EQ(run.status, code) << run.log;
      EXPECT_NE(run.log.find("shared by 2 groups of ranks"), std::string::npos) << run.log;
      EXPECT_TRUE(Splats(out, kIterations) == expected) << ranks << " ranks";
      for (const char* file : {"/per_view.json", "/exposure.json"})
        EXPECT_EQ(Slurp(out + file), Slurp(alone + file)) << ranks << " ranks";
      EXPECT_FALSE(fs::exists(out + "/checkpoint.bin"));
      EXPECT_FALSE(fs::exists(out + "/blocks"));
    }
  }
  const Ended many = Run(5, in_blocks(Out("many"), true));
  EXPECT_NE(many.status, 0);
  EXPECT_EQ(ErrorsIn(many.log).size(), 1u) << many.log;
  EXPECT_NE(many.log.find("--blocks 2 --batch 2: is trained by at most 4 ranks, these are 5"),
            std::string::npos)
      << many.log;
  EXPECT_FALSE(fs::exists(Out("many")));
}

// Each group has a checkpoint of its own block. A rank that trains a block alone waits for no
// other, so it may be ended by mpirun before it notices (Open MPI 6 gives no time): no line of it
// is asked.
TEST_F(RanksTest, ResumeBlocksOnAnotherNumber) {
  constexpr int kIterations = 6000;
  WriteTwoPlaces(Out("places"));
  ASSERT_EQ(Cosplat(InBlocks(Out("undisturbed"), kIterations, 1)).code, kWrong);
  std::vector<std::string> command = InBlocks(Out("killed"), kIterations, 1);
  command.insert(command.end(), {"--checkpoint-every", "0.005"});
  SignalTheSecondOf(2, command, SIGKILL, Out("killed") + "/blocks/2.round-1.bin");
  command.push_back("--resume");
  const CommandResult resumed = Cosplat(command);  // without mpirun
  ASSERT_EQ(resumed.code, kWrong) << resumed.err;
  EXPECT_NE(resumed.out.find("resumed at step"), std::string::npos) << resumed.out;
  EXPECT_TRUE(Splats(Out("killed"), kIterations) == Splats(Out("undisturbed"), kIterations));
}

// From one process to three ranks, of which one is asked to stop, and on with two.
TEST_F(RanksTest, StopBlocksAndResumeThemOnMore) {
  constexpr int kIterations = 6000;
  WriteTwoPlaces(Out("places"));
  ASSERT_EQ(Cosplat(InBlocks(Out("undisturbed"), kIterations, 2)).code, kWrong);
  std::vector<std::string> command = InBlocks(Out("stopped"), kIterations, 2);
  command.insert(command.end(), {"--checkpoint-every", "0.005", "--resume"});
  {
    BackgroundCommand alone(command, Out("log"));
    WaitForFile(Out("stopped") + "/blocks/1.round-1.bin");
    alone.Signal(SIGTERM);
    ASSERT_TRUE(alone.EndsWithin(kPatience));
    EXPECT_EQ(alone.status(), 128 + SIGTERM) << Slurp(Out("log"));
  }
  SignalTheSecondOf(3, command, SIGTERM, Out("stopped") + "/blocks/2.round-1.bin");
  EXPECT_NE(Slurp(Out("log")).find("--resume goes on"), std::string::npos) << Slurp(Out("log"));
  const Ended resumed = Run(2, command);
  ASSERT_EQ(resumed.status, kWrong) << resumed.log;
  EXPECT_NE(resumed.log.find("resumed at step"), std::string::npos) << resumed.log;
  EXPECT_TRUE(Splats(Out("stopped"), kIterations) == Splats(Out("undisturbed"), kIterations));
}

}  // namespace
}  // namespace cosplat::test
