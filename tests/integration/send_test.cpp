// `cosplat send` and the live sources, end to end.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <future>
#include <sstream>

#include "avatar/live/json_frame.h"
#include "avatar/live/source.h"
#include "flame/io/landmarks.h"
#include "splat/base/npz.h"
#include "tests/integration/command.h"

namespace cosplat {
namespace {

using test::CommandResult;
using test::Cosplat;
using test::TemporaryFolder;

// Frame i has expression (i, 0.5).
std::string WriteSequence(const TemporaryFolder& folder, int count) {
  std::vector<float> expression, rotation;
  for (int i = 0; i < count; ++i) {
    expression.insert(expression.end(), {float(i), 0.5f});
    rotation.insert(rotation.end(), {0, 0.01f * float(i), 0});
  }
  Npz npz(folder / "talk.npz");
  npz.Add("expr", {size_t(count), 2}, expression);
  npz.Add("rot", {size_t(count), 3}, rotation);
  npz.Add("fps", {}, std::vector<float>{50});
  npz.Write(npz.path());
  return npz.path();
}

int64_t Now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

TEST(Send, WritesLinesAtTheSequencesPace) {
  const TemporaryFolder folder;
  const int64_t start = Now();
  const CommandResult result = Cosplat({"send", WriteSequence(folder, 20)});
  EXPECT_GE(Now() - start, 19 * 20'000'000);  // the last frame is due 0.38 s after the first
  ASSERT_EQ(result.code, 0) << result.err;
  std::istringstream lines(result.out);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const JsonFrame frame = ParseJsonFrame("standard output", line);
    EXPECT_EQ(frame.sequence, uint64_t(count));
    EXPECT_NEAR(*frame.time, 0.02 * count, 1e-9);
    EXPECT_EQ(frame.params.expression, (std::vector<float>{float(count), 0.5f}));
    EXPECT_NEAR(frame.params.pose[0][1], 0.01f * (float(count) - 9.5f), 1e-5f);  // about its mean
  }
  EXPECT_EQ(count, 20);
}

TEST(Send, ReachesALiveSourceOverLoopback) {
  const TemporaryFolder folder;
  const std::string sequence = WriteSequence(folder, 60);
  const auto source = OpenLiveSource("udp://:0");
  const std::string to = source->Description();
  auto sender = std::async(std::launch::async, [&] {
    return Cosplat({"send", sequence, "--to", to, "--fps", "200", "--drop", "10", "--bad", "20"});
  });
  LiveFrame frame;
  uint64_t last = 0;
  while (sender.wait_for(std::chrono::milliseconds(2)) != std::future_status::ready)
    if (source->Poll(Now(), frame)) {
      EXPECT_TRUE(source->Counts().frames == 1 || frame.sequence > last);
      EXPECT_EQ(frame.params.expression[0], float(frame.sequence));
      last = frame.sequence;
    }
  source->Poll(Now(), frame);
  const CommandResult result = sender.get();
  ASSERT_EQ(result.code, 0) << result.err;
  int sent = 0, corrupted = 0, dropped = 0;
  char address[64];
  ASSERT_EQ(std::sscanf(result.out.c_str(),
                        "%d packets sent to %63s %d of them corrupted; %d dropped",
                        &sent,
                        address,
                        &corrupted,
                        &dropped),
            4)
      << result.out;
  EXPECT_EQ(sent + dropped, 60);
  EXPECT_GT(dropped, 0);
  EXPECT_GT(corrupted, 0);
  const LiveCounts counts = source->Counts();
  EXPECT_EQ(counts.malformed + counts.oversize, uint64_t(corrupted)) << counts.last_problem;
  EXPECT_EQ(counts.frames + counts.replaced + counts.flooded, uint64_t(sent - corrupted));
}

TEST(Send, BlendshapeScoresGoByVmc) {
  const TemporaryFolder folder;
  LandmarkVideo video;
  video.width = video.height = 100;
  video.set = LandmarkSet::kIbug68;
  for (int i = 0; i < 10; ++i) {
    DetectedFace face;
    face.points.assign(68, {50, 50});
    face.blendshapes["jawOpen"] = 0.1f * float(i);
    video.frames.push_back({std::to_string(i), i, {face}, ""});
  }
  const std::string marks = folder / "marks.json";
  WriteLandmarks(marks, video);
  const auto source = OpenLiveSource("vmc://:0");
  const std::string description = source->Description(),
                    to = description.substr(0, description.find(','));
  const CommandResult result = Cosplat({"send", marks, "--to", to, "--fps", "200"});
  ASSERT_EQ(result.code, 0) << result.err;
  LiveFrame frame;
  ASSERT_TRUE(source->Poll(0, frame)) << source->Counts().last_problem;
  EXPECT_EQ(frame.sequence, 9u);
  EXPECT_FLOAT_EQ(frame.params.pose[2][0], 0.45f);  // the general map's jaw
  // As lines, for udp:// and stdin:.
  const CommandResult lines = Cosplat({"send", marks, "--fps", "200"});
  const JsonFrame first = ParseJsonFrame("line", lines.out.substr(0, lines.out.find('\n')));
  EXPECT_EQ(first.blendshapes, video.frames[0].faces[0].blendshapes);
}

TEST(Send, FlameParametersGoByVmcAsHeadAndJaw) {
  const TemporaryFolder folder;
  Npz npz(folder / "nod.npz");
  npz.Add("expr", {2, 1}, std::vector<float>(2));
  npz.Add("rot", {2, 3}, std::vector<float>{-0.1f, 0, 0, 0.1f, 0, 0});
  npz.Add("jaw_rot", {2, 3}, std::vector<float>{0, 0, 0, 0.25f, 0, 0});
  npz.Write(npz.path());
  const auto source = OpenLiveSource("vmc://:0");
  const std::string description = source->Description();
  const CommandResult result = Cosplat(
      {"send", npz.path(), "--to", description.substr(0, description.find(',')), "--fps", "200"});
  ASSERT_EQ(result.code, 0) << result.err;
  LiveFrame frame;
  ASSERT_TRUE(source->Poll(0, frame)) << source->Counts().last_problem;
  EXPECT_EQ(frame.sequence, 1u);
  EXPECT_NEAR(frame.params.pose[0][0], 0.1f, 1e-5f);
  EXPECT_NEAR(frame.params.pose[2][0], 0.25f, 1e-3f);
}

TEST(Send, PipesIntoStandardInput) {
  const TemporaryFolder folder;
  const std::string sequence = WriteSequence(folder, 5), pipe = folder / "pipe";
  ASSERT_EQ(std::system(("mkfifo '" + pipe + "'").c_str()), 0);
  auto sender = std::async(std::launch::async, [&] {
    return std::system(("'" COSPLAT_COMMAND "' send '" + sequence + "' >'" + pipe + "'").c_str());
  });
  const int kept = dup(STDIN_FILENO), descriptor = open(pipe.c_str(), O_RDONLY);
  ASSERT_EQ(dup2(descriptor, STDIN_FILENO), STDIN_FILENO);
  const auto source = OpenLiveSource("stdin:");
  LiveFrame frame;
  while (!source->Ended()) {
    source->Poll(Now(), frame);
    ::poll(nullptr, 0, 2);
  }
  EXPECT_EQ(frame.sequence, 4u);
  EXPECT_EQ(source->Counts().malformed, 0u);
  EXPECT_EQ(sender.get(), 0);
  dup2(kept, STDIN_FILENO);
  close(kept);
  close(descriptor);
}

TEST(Send, BadInputIsNamed) {
  const TemporaryFolder folder;
  const std::string sequence = WriteSequence(folder, 2);
  const auto expect = [](const std::vector<std::string>& arguments, const std::string& part) {
    const CommandResult result = Cosplat(arguments);
    EXPECT_EQ(result.code, 2);
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    EXPECT_EQ(result.out, "");
  };
  expect({"send", folder / "none.npz"}, "none.npz: does not exist");
  expect({"send", sequence, "--to", "tcp://:39539"}, "expected udp://HOST:PORT");
  expect({"send", sequence, "--to", "udp://:0"}, "expected udp://HOST:PORT");
  expect({"send", sequence, "--fps", "20000"}, "frames per second");
  expect({"send", sequence, "--drop", "60", "--bad", "60"}, "--drop and --bad");
  const CommandResult nobody = Cosplat({"send", sequence, "--to", "udp://127.0.0.1:9"});
  EXPECT_EQ(nobody.code, 0);  // as with any tracker: it may be listened to later
}

}  // namespace
}  // namespace cosplat
