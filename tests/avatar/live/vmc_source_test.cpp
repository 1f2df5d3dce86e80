#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "avatar/live/packet_input.h"
#include "avatar/live/udp_socket.h"
#include "avatar/live/vmc_frame.h"
#include "splat/base/npz.h"
#include "tests/avatar/live/osc_builder.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::OscBundle;
using test::TemporaryFolder;
using test::VmcApply;
using test::VmcBone;
using test::VmcValue;

// Expression i follows blendshapes i and 51; the jaw follows jawOpen, the left eye eyeLookDownLeft.
std::string WriteMatrix(const TemporaryFolder& folder) {
  constexpr size_t kCount = 10;
  std::vector<float> expression(52 * kCount), jaw(52 * 3), eye(52 * 3);
  for (size_t i = 0; i < kCount; ++i) {
    expression[i * kCount + i] = 2;
    expression[51 * kCount + i] = 1;
  }
  jaw[17 * 3] = 0.3f;
  eye[1 * 3] = 0.4f;
  Npz npz(folder / "matrix.npz");
  npz.Add("expression", {52, kCount}, expression);
  npz.Add("jaw", {52, 3}, jaw);
  npz.Add("left_eye", {52, 3}, eye);
  npz.Write(npz.path());
  return npz.path();
}

struct Connection {
  TemporaryFolder folder;
  std::unique_ptr<LiveSource> source;
  UdpSocket sender;

  explicit Connection(const LiveSourceOptions& options = {})
      : source(OpenLiveSource("vmc://:0?matrix=" + WriteMatrix(folder), options)),
        sender(UdpSocket::ConnectTo(ParseDriveAddress(test::AddressOf(*source)))) {}
  void Send(const std::string& packet) { ASSERT_TRUE(sender.Send(packet)); }
};

TEST(VmcSource, AFrameIsWhatWasSentUntilItsEnd) {
  Connection connection;
  LiveFrame frame;
  connection.Send(VmcApply());  // a sender that ends its frames
  ASSERT_TRUE(connection.source->Poll(0, frame));
  connection.Send(VmcValue("eyeBlinkLeft", 0.5f));
  connection.Send(OscBundle({VmcValue("EyeLookDownLeft", 1), VmcValue("JAWOPEN", 0.5f)}));
  EXPECT_FALSE(connection.source->Poll(0, frame));
  connection.Send(VmcApply());
  connection.Send(VmcValue("eyeBlinkLeft", 1));  // of a frame that has not ended
  ASSERT_TRUE(connection.source->Poll(7, frame));
  EXPECT_EQ(frame.params.expression, (std::vector<float>{1, 2, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_FLOAT_EQ(frame.params.pose[2][0], 0.15f);
  EXPECT_FLOAT_EQ(frame.params.pose[3][0], 0.4f);
  EXPECT_FLOAT_EQ(frame.params.pose[4][0], 0);
  EXPECT_EQ(frame.sequence, 1u);
  EXPECT_EQ(frame.time_ns, 7);
  EXPECT_FALSE(connection.source->Poll(8, frame));
  connection.Send(VmcApply());
  connection.Send(VmcApply());
  ASSERT_TRUE(connection.source->Poll(9, frame));
  EXPECT_EQ(frame.params.expression[0], 2);
  EXPECT_EQ(frame.params.expression[1], 2);  // stays
  EXPECT_EQ(frame.sequence, 3u);
  EXPECT_EQ(connection.source->Counts().replaced, 1u);
}

TEST(VmcSource, ValuesAreOfZeroToOneAndOtherNamesAreLeftOut) {
  Connection connection;
  connection.Send(OscBundle({VmcValue("eyeBlinkLeft", 1.5f),
                             VmcValue("eyeLookDownLeft", -1),
                             VmcValue("Joy", 1),
                             test::OscText("/VMC/Ext/OK") + test::OscText(",i") + test::OscWord(1),
                             VmcApply()}));
  LiveFrame frame;
  ASSERT_TRUE(connection.source->Poll(0, frame));
  EXPECT_EQ(frame.params.expression, (std::vector<float>{2, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(connection.source->Counts().last_problem, "");
}

// Unity: x to the subject's right, y up, z forward, left-handed.
TEST(VmcSource, BonesTurnTheHead) {
  LiveSourceOptions options;
  options.rest.pose[0] = {0, 0.5f, 0};
  options.rest.translation = {0, 0, 3};
  Connection connection(options);
  const float s = std::sin(0.1f), c = std::cos(0.1f);  // turns by 0.2 rad
  connection.Send(VmcBone("Neck", {0, s, 0, c}));      // towards +x: the subject's right
  connection.Send(VmcBone("Head", {s, 0, 0, c}));      // z goes to -y: looks down
  connection.Send(VmcBone("Hips", {1, 0, 0, 0}));
  connection.Send(VmcApply());
  LiveFrame frame;
  ASSERT_TRUE(connection.source->Poll(0, frame));
  EXPECT_NEAR(frame.params.pose[0][1], 0.5f - 0.2f, 1e-6f);  // +y is to the subject's left
  EXPECT_NEAR(frame.params.pose[1][0], 0.2f, 1e-6f);         // +x is down
  EXPECT_EQ(frame.params.translation[2], 3);
}

TEST(VmcSource, ABadMessageIsDroppedAndTheRestIsTaken) {
  Connection connection;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::string value = test::OscText("/VMC/Ext/Blend/Val");
  const std::string bad[] = {
      "nonsense",
      VmcValue("jawOpen", kNan),
      VmcValue("jawOpen", 37),
      VmcBone("Head", {0, 0, 0, 0}),
      VmcBone("Head", {0, 0, kNan, 1}),
      VmcBone("Head", {0, 0, 1}),
      value + test::OscText(",s") + test::OscText("jawOpen"),
      value + test::OscText(",ss") + test::OscText("jawOpen") + test::OscText("0.5"),
      value + test::OscText(",sf") + test::OscText("jawOpen"),
      value + test::OscText(",ff") + test::OscFloat(1) + test::OscFloat(1),
  };
  uint64_t count = 0;
  LiveFrame frame;
  for (const std::string& packet : bad) {
    const float blink = 0.05f * float(++count);
    connection.Send(OscBundle({packet, VmcValue("eyeBlinkLeft", blink), VmcApply()}));
    ASSERT_TRUE(connection.source->Poll(0, frame));
    EXPECT_FLOAT_EQ(frame.params.expression[0], 2 * blink);
    EXPECT_EQ(frame.params.pose[2][0], 0);
    EXPECT_EQ(connection.source->Counts().malformed, count);
  }
  EXPECT_EQ(connection.source->Counts().last_problem,
            test::AddressOf(*connection.source) +
                ": /VMC/Ext/Blend/Val: expected a name and 1 finite number");
}

TEST(VmcSource, ErrorsOfTheMatrixNameFileAndArray) {
  const TemporaryFolder folder;
  const std::string path = folder / "m.npz", drive = "vmc://:0?matrix=" + path;
  const auto expect = [&](const std::vector<std::string>& parts) {
    ExpectError([&] { OpenLiveSource(drive); }, parts);
  };
  const auto write = [&](const std::string& name, std::vector<size_t> shape, float value) {
    Npz npz(path);
    npz.Add("expression", {52, 1}, std::vector<float>(52));
    npz.Add(name, shape, std::vector<float>(shape[0] * shape[1], value));
    npz.Write(path);
  };
  for (const char* query : {"?matrix=", "?map=m.npz"})
    ExpectError([&] { OpenLiveSource(std::string("vmc://:0") + query); },
                {"vmc://:0", query, "expected vmc://HOST:PORT?matrix=FILE"});
  expect({"m.npz"});  // does not exist
  write("expression", {51, 50}, 0);
  expect({"m.npz", "expression", "51", "52"});
  write("expression", {52, 50}, std::numeric_limits<float>::infinity());
  expect({"m.npz", "expression", "column 0"});
  write("jaw", {52, 3}, 3);
  expect({"m.npz", "jaw", "156", "100"});
  write("jaw", {52, 4}, 0);
  expect({"m.npz", "jaw", "4"});
  write("jaw", {52, 3}, 0.1f);
  EXPECT_NO_THROW(OpenLiveSource(drive));
}

// A map with one score, which sets one coefficient, the jaw and an offset.
BlendshapeMap OwnMap() {
  BlendshapeMap map;
  map.names = {"jawOpen"};
  map.min = {0.2f};
  map.max = {0.6f};
  map.offset.assign(2 + kMappedTurns, 0.0f);
  map.matrix.assign(2 + kMappedTurns, 0.0f);
  map.offset[0] = 0.5f;
  map.matrix[1] = 2;
  map.matrix[2] = 0.4f;  // of the jaw, about x
  return map;
}

LiveFrame FrameAfter(LiveSource& source, const BlendshapeScores& scores) {
  UdpSocket sender = UdpSocket::ConnectTo(ParseDriveAddress(test::AddressOf(source)));
  EXPECT_TRUE(sender.Send(WriteVmcFrame(scores)));
  LiveFrame frame;
  EXPECT_TRUE(source.Poll(0, frame)) << source.Counts().last_problem;
  return frame;
}

TEST(VmcSource, WithoutAMatrixTheAvatarsOwnMapIsUsed) {
  const BlendshapeMap map = OwnMap();
  LiveSourceOptions options;
  options.blendshapes = &map;
  const auto source = OpenLiveSource("vmc://:0", options);
  EXPECT_NE(source->Description().find("the avatar's own blendshape map"), std::string::npos);
  const LiveFrame frame = FrameAfter(*source, {{"jawOpen", 0.5f}, {"tongueOut", 1}});
  EXPECT_EQ(frame.params.expression, (std::vector<float>{0.5f, 1}));
  EXPECT_FLOAT_EQ(frame.params.pose[2][0], 0.2f);
  // Beyond what training showed, scores are limited softly.
  const LiveFrame wide = FrameAfter(*source, {{"jawOpen", 1}});
  EXPECT_GT(wide.params.expression[1], 2 * 0.6f);
  EXPECT_LE(wide.params.expression[1], 2 * 0.7f);
  const LiveFrame shut = FrameAfter(*source, {{"jawOpen", 0}});
  EXPECT_GE(shut.params.expression[1], 2 * 0.1f);
  EXPECT_LT(shut.params.expression[1], 2 * 0.2f);
}

TEST(VmcSource, AMatrixWinsOverTheAvatarsMap) {
  const TemporaryFolder folder;
  const BlendshapeMap map = OwnMap();
  LiveSourceOptions options;
  options.blendshapes = &map;
  const auto source = OpenLiveSource("vmc://:0?matrix=" + WriteMatrix(folder), options);
  EXPECT_NE(source->Description().find("by matrix.npz"), std::string::npos);
  EXPECT_FLOAT_EQ(FrameAfter(*source, {{"jawOpen", 1}}).params.pose[2][0], 0.3f);
}

TEST(VmcSource, OnAnyAvatarJawLidsAndGazeMove) {
  FlameModel flame;
  flame.expression_count = 5;
  LiveSourceOptions options;
  options.flame = &flame;
  const BlendshapeScores scores{{"jawOpen", 1},
                                {"eyeBlinkLeft", 0.5f},
                                {"eyeBlinkRight", 1},
                                {"eyeLookInLeft", 1},
                                {"eyeLookOutRight", 1},
                                {"eyeLookUpLeft", 1},
                                {"eyeLookDownRight", 1},
                                {"mouthSmileLeft", 1}};
  for (const bool lids : {false, true}) {
    flame.has_eyelids = lids;
    const auto source = OpenLiveSource("vmc://:0", options);
    EXPECT_NE(source->Description().find(lids ? "jaw, eyelids and gaze only" : "jaw and gaze only"),
              std::string::npos);
    const FlameParams face = FrameAfter(*source, scores).params;
    EXPECT_EQ(face.expression,
              (lids ? std::vector<float>{0, 0, 0, 0.5f, 1} : std::vector<float>(5)));
    EXPECT_FLOAT_EQ(face.pose[2][0], 0.5f);  // +x is down, +y towards the subject's left
    EXPECT_LT(face.pose[3][1], -0.1f);       // both look to the right
    EXPECT_LT(face.pose[4][1], -0.1f);
    EXPECT_LT(face.pose[3][0], -0.1f);  // up
    EXPECT_GT(face.pose[4][0], 0.1f);   // down
  }
  EXPECT_EQ(ProblemOf(GeneralBlendshapeMap(&flame)), "");
  EXPECT_EQ(ProblemOf(GeneralBlendshapeMap(nullptr)), "");
}

TEST(VmcSource, ADirectionWithAnArkitNameMovesByIt) {
  FlameModel flame;
  flame.expression_count = 4;
  flame.has_eyelids = true;
  flame.expression_names = {"", "mouthSmileLeft", "eyeBlinkLeft", "eyeBlinkRight"};
  flame.expression_scores = {0, 4, 1, 1};
  LiveSourceOptions options;
  options.flame = &flame;
  const auto source = OpenLiveSource("vmc://:0", options);
  EXPECT_NE(source->Description().find("the head's own directions"), std::string::npos);
  const FlameParams face =
      FrameAfter(*source, {{"mouthSmileLeft", 0.5f}, {"eyeBlinkRight", 1}, {"jawOpen", 1}}).params;
  EXPECT_EQ(face.expression, (std::vector<float>{0, 2, 0, 1}));
  EXPECT_FLOAT_EQ(face.pose[2][0], 0.5f);
}

TEST(Arkit, NamesAreFoundInEitherCase) {
  for (size_t i = 0; i < kArkitNames.size(); ++i)
    EXPECT_EQ(FindArkitBlendshape(kArkitNames[i]), int(i));
  EXPECT_EQ(FindArkitBlendshape("JawOpen"), 17);
  EXPECT_EQ(FindArkitBlendshape("tongueout"), 51);
  EXPECT_EQ(FindArkitBlendshape("jaw"), -1);
  EXPECT_EQ(FindArkitBlendshape(""), -1);
}

}  // namespace
}  // namespace cosplat
