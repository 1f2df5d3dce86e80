#include <gtest/gtest.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "avatar/live/json_frame.h"
#include "avatar/live/packet_input.h"
#include "avatar/live/sender_clock.h"
#include "avatar/live/udp_socket.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr int64_t kMillisecond = 1'000'000;

std::string Line(uint64_t sequence, float jaw = 0) {
  JsonFrame frame;
  frame.sequence = sequence;
  frame.params.pose[2][0] = jaw;
  return WriteJsonFrame(frame);
}

// A source on loopback and what sends to it.
struct Connection {
  std::unique_ptr<LiveSource> source;
  UdpSocket sender;

  explicit Connection(const LiveSourceOptions& options = {})
      : source(OpenLiveSource("udp://:0", options)),
        sender(UdpSocket::ConnectTo(ParseDriveAddress(source->Description()))) {}
  void Send(const std::string& packet) { ASSERT_TRUE(sender.Send(packet)); }
};

TEST(JsonSource, TheNewestFrameOfADatagramEach) {
  Connection connection;
  LiveFrame frame;
  EXPECT_FALSE(connection.source->Poll(0, frame));
  for (int i = 0; i < 3; ++i) connection.Send(Line(10 + i, 0.1f * float(i)));
  ASSERT_TRUE(connection.source->Poll(5, frame));
  EXPECT_EQ(frame.sequence, 12u);
  EXPECT_EQ(frame.time_ns, 5);
  EXPECT_EQ(frame.params.pose[2][0], 0.2f);
  EXPECT_FALSE(connection.source->Poll(6, frame));
  EXPECT_EQ(connection.source->Counts().frames, 1u);
  EXPECT_EQ(connection.source->Counts().replaced, 2u);
  EXPECT_FALSE(connection.source->Ended());
}

TEST(JsonSource, BlendshapesMoveTheFaceByTheMap) {
  Connection connection;
  connection.Send(R"({"seq": 1, "blendshapes": {"jawOpen": 0.5, "Joy": 1}, "neck": [0, 0.1, 0]})");
  LiveFrame frame;
  ASSERT_TRUE(connection.source->Poll(0, frame)) << connection.source->Counts().last_problem;
  EXPECT_FLOAT_EQ(frame.params.pose[2][0], 0.25f);  // of the general map, half open
  EXPECT_FLOAT_EQ(frame.params.pose[1][1], 0.1f);
  connection.Send(R"({"seq": 2, "blendshapes": {}})");
  ASSERT_TRUE(connection.source->Poll(1, frame));
  EXPECT_EQ(frame.params.pose[2][0], 0);
}

TEST(JsonSource, WhatIsBadIsCountedAndTheRestIsTaken) {
  Connection connection;
  const std::string packets[] = {
      Line(5), Line(4), Line(5), "{", "", std::string(kMaxPacketBytes + 1, ' '), Line(6, 0.5f)};
  for (const std::string& packet : packets) connection.Send(packet);
  LiveFrame frame;
  ASSERT_TRUE(connection.source->Poll(0, frame));
  EXPECT_EQ(frame.sequence, 6u);
  const LiveCounts counts = connection.source->Counts();
  EXPECT_EQ(counts.replaced, 1u);
  EXPECT_EQ(counts.reordered, 2u);
  EXPECT_EQ(counts.malformed, 2u);
  EXPECT_EQ(counts.oversize, 1u);
  EXPECT_EQ(counts.flooded, 0u);

  connection.Send("{\"seq\": 7, \"jaw\": [0]}");
  EXPECT_FALSE(connection.source->Poll(1, frame));
  EXPECT_EQ(frame.sequence, 6u);
  EXPECT_EQ(connection.source->Counts().last_problem,
            connection.source->Description() + ": jaw: found 1 numbers, expected 3");
}

TEST(JsonSource, OfAFloodTheNewestAreLookedAt) {
  Connection connection;
  for (int i = 0; i < 40; ++i) connection.Send(Line(i));
  LiveFrame frame;
  ASSERT_TRUE(connection.source->Poll(0, frame));
  EXPECT_EQ(frame.sequence, 39u);
  EXPECT_EQ(connection.source->Counts().flooded, 8u);
  EXPECT_EQ(connection.source->Counts().replaced, 31u);
}

TEST(JsonSource, ASenderThatRestartsIsTakenUpAgain) {
  Connection connection;
  LiveFrame frame;
  connection.Send(Line(100));
  ASSERT_TRUE(connection.source->Poll(0, frame));
  connection.Send(Line(0));
  EXPECT_FALSE(connection.source->Poll(100 * kMillisecond, frame));
  connection.Send(Line(1));
  EXPECT_TRUE(connection.source->Poll(SequenceFilter::kRestartPauseNs, frame));
  EXPECT_EQ(frame.sequence, 1u);
}

TEST(JsonSource, SoIsItsClock) {
  Connection connection;
  LiveFrame frame;
  connection.Send(R"({"seq": 0, "time": 0})");
  ASSERT_TRUE(connection.source->Poll(0, frame));
  connection.Send(R"({"seq": 25, "time": 1})");
  ASSERT_TRUE(connection.source->Poll(1000 * kMillisecond, frame));
  connection.Send(R"({"seq": 0, "time": 0})");  // by the old clock more than a second ago
  ASSERT_TRUE(connection.source->Poll(1600 * kMillisecond, frame));
  EXPECT_EQ(frame.time_ns, 1600 * kMillisecond);
}

TEST(JsonSource, TimestampsAreBroughtToThePollersClock) {
  Connection connection;
  LiveFrame frame;
  const auto send = [&](int i) {
    connection.Send("{\"seq\": " + std::to_string(i) +
                    ", \"time\": " + std::to_string(1.7e9 + 0.04 * i) + "}");
  };
  send(0);
  ASSERT_TRUE(connection.source->Poll(1000 * kMillisecond, frame));
  EXPECT_EQ(frame.time_ns, 1000 * kMillisecond);
  send(1);
  ASSERT_TRUE(connection.source->Poll(1055 * kMillisecond, frame));  // 15 ms late
  EXPECT_NEAR(double(frame.time_ns), 1040e6, 1e5);
}

TEST(JsonSource, TheRootCountsFromTheAvatarsRest) {
  LiveSourceOptions options;
  options.rest.pose[0] = {0, 1, 0};
  options.rest.translation = {0, 0, 2};
  Connection connection(options);
  connection.Send(R"({"seq": 1, "pose": [0, 0.25, 0], "translation": [0.5, 0, 0]})");
  LiveFrame frame;
  ASSERT_TRUE(connection.source->Poll(0, frame));
  EXPECT_NEAR(frame.params.pose[0][1], 1.25f, 1e-6f);
  EXPECT_EQ(frame.params.translation, (std::array<float, 3>{0.5f, 0, 2}));
}

TEST(JsonSource, OverIPv6) {
  std::unique_ptr<LiveSource> source;
  try {
    source = OpenLiveSource("udp://[::1]:0");
  } catch (const Error&) {
    GTEST_SKIP() << "no IPv6 here";
  }
  UdpSocket sender = UdpSocket::ConnectTo(ParseDriveAddress(source->Description()));
  ASSERT_TRUE(sender.Send(Line(1)));
  LiveFrame frame;
  EXPECT_TRUE(source->Poll(0, frame));
}

// The ends of a pipe.
struct Pipe {
  int read_end = -1, write_end = -1;
  Pipe() {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    read_end = ends[0];
    write_end = ends[1];
  }
  ~Pipe() {
    close(read_end);
    CloseWriter();
  }
  void Write(const std::string& text) const {
    ASSERT_EQ(write(write_end, text.data(), text.size()), ssize_t(text.size()));
  }
  void CloseWriter() {
    if (write_end >= 0) close(write_end);
    write_end = -1;
  }
};

TEST(JsonSource, LinesOfAPipe) {
  Pipe pipe;
  const auto source = OpenJsonSource(
      OpenLineInput(pipe.read_end, "standard input"), ChooseBlendshapeMap("", {}), {});
  LiveFrame frame;
  EXPECT_FALSE(source->Poll(0, frame));
  const std::string line = Line(2);
  pipe.Write(Line(1) + "\r\n\n" + line.substr(0, 10));
  ASSERT_TRUE(source->Poll(0, frame));
  EXPECT_EQ(frame.sequence, 1u);
  pipe.Write(line.substr(10));
  EXPECT_FALSE(source->Poll(0, frame));  // its line has not ended
  EXPECT_FALSE(source->Ended());
  pipe.CloseWriter();
  ASSERT_TRUE(source->Poll(0, frame));
  EXPECT_EQ(frame.sequence, 2u);
  EXPECT_TRUE(source->Ended());
  EXPECT_EQ(source->Counts().malformed, 0u);
}

TEST(JsonSource, ALineThatIsTooLongCostsOnlyItself) {
  Pipe pipe;
  const auto source = OpenJsonSource(
      OpenLineInput(pipe.read_end, "standard input"), ChooseBlendshapeMap("", {}), {});
  LiveFrame frame;
  for (int i = 0; i < 3; ++i) {
    pipe.Write(std::string(kMaxPacketBytes / 2, ' '));
    EXPECT_FALSE(source->Poll(0, frame));
  }
  pipe.Write("\n");
  pipe.Write(Line(4) + "\n");
  ASSERT_TRUE(source->Poll(0, frame));
  EXPECT_EQ(source->Counts().oversize, 1u);
  EXPECT_EQ(source->Counts().last_problem,
            "standard input: a packet of 24576 bytes, at most 16384 are accepted");
}

TEST(JsonSource, AClosedInputHasEnded) {
  Pipe pipe;
  const int closed = dup(pipe.read_end);
  const auto source =
      OpenJsonSource(OpenLineInput(closed, "standard input"), ChooseBlendshapeMap("", {}), {});
  close(closed);
  LiveFrame frame;
  EXPECT_FALSE(source->Poll(0, frame));
  EXPECT_TRUE(source->Ended());
}

}  // namespace
}  // namespace cosplat
