// Apps on phones, over real sockets: what is asked, what is read, what is refused.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "avatar/live/packet_input.h"
#include "avatar/live/udp_socket.h"
#include "splat/base/error.h"
#include "splat/base/json.h"
#include "tests/avatar/live/phone_packets.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::IFacialMocapPacket;
using test::LiveLinkPacket;
using test::VtsPacket;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// iFacialMocap's port may be another test's for a moment.
std::unique_ptr<LiveSource> OpenWhenFree(const std::string& drive,
                                         const LiveSourceOptions& options) {
  for (int tries = 100; tries > 0; --tries) {
    try {
      return OpenLiveSource(drive, options);
    } catch (const Error& error) {
      if (std::string(error.what()).find("already in use") == std::string::npos) throw;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return OpenLiveSource(drive, options);
}

// An app that waits to be asked.
struct Phone {
  UdpSocket listening;
  std::unique_ptr<LiveSource> source;
  LiveFrame frame;

  explicit Phone(const std::string& scheme,
                 const std::string& query = "",
                 const LiveSourceOptions& options = {})
      : listening(UdpSocket::Listen(ParseDriveAddress("udp://:0"))),
        source(OpenWhenFree(scheme + "://" + listening.LocalAddress() + query, options)) {}

  // What it was asked, or "".
  std::string Asked() {
    char buffer[1024];
    Peer from;
    const long size = listening.Receive(buffer, sizeof(buffer), from);
    return size < 0 ? "" : std::string(buffer, size_t(size));
  }
  // The address that the source listens on.
  std::string Answered() const {
    const std::string description = source->Description();
    const size_t to = description.find(" to ") + 4;
    return description.substr(to, description.find(',') - to);
  }
  void Send(const std::string& packet) {
    ASSERT_TRUE(UdpSocket::ConnectTo(ParseDriveAddress("udp://" + Answered())).Send(packet));
  }
  bool Poll(int64_t now_ns = 0) { return source->Poll(now_ns, frame); }
  LiveCounts Counts() const { return source->Counts(); }
};

// By the general map, which opens by half a radian at a score of 1.
float JawOpen(const LiveFrame& frame) { return 2 * frame.params.pose[2][0]; }

void ExpectTurn(const LiveFrame& frame, float down, float left, float right_shoulder) {
  constexpr float kDegrees = 180 / 3.14159265f;
  EXPECT_NEAR(frame.params.pose[0][0] * kDegrees, down, 1e-3f);
  EXPECT_NEAR(frame.params.pose[0][1] * kDegrees, left, 1e-3f);
  EXPECT_NEAR(frame.params.pose[0][2] * kDegrees, right_shoulder, 1e-3f);
}

TEST(VtsSource, AsksThePhoneEverySecondForItsOwnPort) {
  Phone phone("vts");
  EXPECT_FALSE(phone.Poll());
  const Json request = ParseJson("request", phone.Asked());
  EXPECT_EQ(request["messageType"], "iOSTrackingDataRequest");
  EXPECT_EQ(request["sentBy"], "CoSplat");
  EXPECT_GE(request["time"].get<double>(), 1.5);  // one request may get lost
  EXPECT_LE(request["time"].get<double>(), 10);
  ASSERT_EQ(request["ports"].size(), 1u);
  const std::string port = std::to_string(request["ports"][0].get<int>());
  EXPECT_NE(phone.source->Description().find(" to 127.0.0.1:" + port + ","), std::string::npos)
      << phone.source->Description();
  EXPECT_FALSE(phone.Poll());
  EXPECT_EQ(phone.Asked(), "");
  std::this_thread::sleep_for(std::chrono::milliseconds(1050));
  EXPECT_FALSE(phone.Poll());
  EXPECT_EQ(ParseJson("request", phone.Asked()), request);
}

TEST(VtsSource, ScoresAndHeadOfTheNewestFrame) {
  LiveSourceOptions options;
  options.rest.translation = {0, 0, 3};
  Phone phone("vts", "", options);
  phone.Send(VtsPacket(R"({"k":"JawOpen","v":0.25})"));
  phone.Send(VtsPacket(R"({"k":"JawOpen","v":0.5},{"k":"EyeLookUpLeft","v":1},{"k":"Other","v":1})",
                       {10, 0, 0}));
  ASSERT_TRUE(phone.Poll(7)) << phone.Counts().last_problem;
  EXPECT_FLOAT_EQ(JawOpen(phone.frame), 0.5f);
  EXPECT_FLOAT_EQ(phone.frame.params.pose[3][0], -0.3f);  // up, by the score
  EXPECT_EQ(phone.frame.params.translation[2], 3);
  EXPECT_EQ(phone.frame.time_ns, 7);
  EXPECT_EQ(phone.frame.sequence, 1u);
  EXPECT_EQ(phone.Counts().replaced, 1u);
  EXPECT_EQ(NotesOf(phone.Counts()), "ignored blendshapes: Other (1)");
  ExpectTurn(phone.frame, 0, -10, 0);
  EXPECT_FALSE(phone.Poll(8));
  // What is not sent again is zero.
  phone.Send(VtsPacket("", {0, 10, 0}));
  ASSERT_TRUE(phone.Poll(9));
  EXPECT_EQ(JawOpen(phone.frame), 0);
  ExpectTurn(phone.frame, 10, 0, 0);
  phone.Send(VtsPacket("", {0, 0, 10}));
  ASSERT_TRUE(phone.Poll(9));
  ExpectTurn(phone.frame, 0, 0, -10);
}

TEST(VtsSource, WithoutAFaceThereIsNoFrame) {
  Phone phone("vts");
  phone.Send(test::kVtsNoFace);
  EXPECT_FALSE(phone.Poll());
  EXPECT_EQ(phone.Counts().malformed, 0u);
  EXPECT_EQ(phone.Counts().unusable, 1u);
  EXPECT_EQ(NotesOf(phone.Counts()), "ignored messages: no face (1)");
}

TEST(VtsSource, BadPacketsAreNamedAndABadScoreCostsOnlyItself) {
  Phone phone("vts");
  const std::pair<std::string, std::string> cases[] = {
      {"nonsense", "line 1"},
      {"[]", "FaceFound"},
      {R"({"FaceFound":1})", "FaceFound: is neither true nor false"},
      {R"({"FaceFound":true,"Rotation":{"x":0,"y":0,"z":0}})", "BlendShapes"},
      {R"({"FaceFound":true,"BlendShapes":[]})", "Rotation"},
      {R"({"FaceFound":true,"BlendShapes":[{"v":1}],"Rotation":{"x":0,"y":0,"z":0}})", "k"},
      {VtsPacket("", {0, 361, 0}), "Rotation.y: found 361"},
      {R"({"FaceFound":true,"BlendShapes":[],"Rotation":{"x":NaN,"y":0,"z":0}})", "Rotation.x"},
      {std::string(300, '['), "more than 256 arrays and objects"}};
  uint64_t count = 0;
  for (const auto& [packet, problem] : cases) {
    phone.Send(packet);
    EXPECT_FALSE(phone.Poll());
    EXPECT_EQ(phone.Counts().malformed, ++count) << packet;
    EXPECT_NE(phone.Counts().last_problem.find(problem), std::string::npos)
        << phone.Counts().last_problem;
  }
  phone.Send(
      VtsPacket(R"({"k":"JawOpen","v":0.5},{"k":"JawLeft","v":NaN},{"k":"JawRight","v":40})"));
  ASSERT_TRUE(phone.Poll());
  EXPECT_FLOAT_EQ(JawOpen(phone.frame), 0.5f);
  EXPECT_EQ(phone.Counts().malformed, count + 2);
  EXPECT_EQ(NotesOf(phone.Counts()), "dropped: JawLeft (1), JawRight (1)");
}

TEST(VtsSource, OnlyThePhoneItselfIsListenedTo) {
  Phone phone("vts");
  // Loopback is a whole network: another host of it.
  sockaddr_in stranger{}, to{};
  stranger.sin_family = to.sin_family = AF_INET;
  stranger.sin_addr.s_addr = inet_addr("127.0.0.2");
  to.sin_addr.s_addr = inet_addr("127.0.0.1");
  to.sin_port = htons(uint16_t(ParseDriveAddress("udp://" + phone.Answered()).port));
  const int descriptor = socket(AF_INET, SOCK_DGRAM, 0);
  ASSERT_EQ(bind(descriptor, reinterpret_cast<sockaddr*>(&stranger), sizeof(stranger)), 0);
  const std::string packet = VtsPacket(R"({"k":"JawOpen","v":1})");
  ASSERT_EQ(sendto(descriptor,
                   packet.data(),
                   packet.size(),
                   0,
                   reinterpret_cast<sockaddr*>(&to),
                   sizeof(to)),
            ssize_t(packet.size()));
  close(descriptor);
  EXPECT_FALSE(phone.Poll());
  EXPECT_EQ(phone.Counts().packets, 1u);
  EXPECT_EQ(phone.Counts().unusable, 1u);
  EXPECT_EQ(NotesOf(phone.Counts()), "ignored messages: from 127.0.0.2:0 (1)");
}

TEST(VtsSource, AnAppThatIsNotOpenIsSaid) {
  std::string taken;
  {
    const UdpSocket gone = UdpSocket::Listen(ParseDriveAddress("udp://:0"));
    taken = gone.LocalAddress();
  }
  const auto source = OpenLiveSource("vts://" + taken);
  LiveFrame frame;
  EXPECT_FALSE(source->Poll(0, frame));
  std::this_thread::sleep_for(std::chrono::milliseconds(1050));
  EXPECT_FALSE(source->Poll(0, frame));
  EXPECT_NE(source->Counts().last_problem.find("the phone refuses requests: is its app open?"),
            std::string::npos)
      << source->Counts().last_problem;
}

TEST(IFacialMocapSource, AsksAndReadsBothVersions) {
  Phone phone("ifacialmocap");
  EXPECT_FALSE(phone.Poll());
  EXPECT_EQ(phone.Asked(), "iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719");
  EXPECT_NE(phone.source->Description().find(" to 127.0.0.1:49983,"), std::string::npos);
  for (const char* scores : {"jawOpen-50|eyeLookUp_L-100|", "jawOpen&50|eyeLookUp_L & 100|"}) {
    phone.Send(IFacialMocapPacket(scores, "10,0,0,0.1,0.2,0.4"));
    ASSERT_TRUE(phone.Poll()) << phone.Counts().last_problem;
    EXPECT_FLOAT_EQ(JawOpen(phone.frame), 0.5f);
    EXPECT_FLOAT_EQ(phone.frame.params.pose[3][0], -0.3f);
    ExpectTurn(phone.frame, 10, 0, 0);
  }
  phone.Send(IFacialMocapPacket("jawOpen--5|", "0,10,0,0,0,0"));
  ASSERT_TRUE(phone.Poll());
  EXPECT_EQ(JawOpen(phone.frame), 0);
  ExpectTurn(phone.frame, 0, 10, 0);
  phone.Send(IFacialMocapPacket("", "0,0,10,0,0,0"));
  ASSERT_TRUE(phone.Poll());
  ExpectTurn(phone.frame, 0, 0, 10);
  EXPECT_EQ(NotesOf(phone.Counts()), "");
  // A second one cannot have the port that the app answers to.
  ExpectError([&] { OpenLiveSource("ifacialmocap://127.0.0.1:9"); }, {"already in use"});
}

TEST(IFacialMocapSource, BadPacketsAreNamedAndABadScoreCostsOnlyItself) {
  Phone phone("ifacialmocap");
  std::string many;
  for (int i = 0; i < 300; ++i) many += "a-1|";
  const std::pair<std::string, std::string> cases[] = {
      {"nonsense", "head: is missing"},
      {"jawOpen-50|", "head: is missing"},
      {IFacialMocapPacket("", "1,2"), "head: found nan"},
      {IFacialMocapPacket("", "1,2,1e9,0,0,0"), "head: found 1000000000"},
      {IFacialMocapPacket("", "1,nan,2,0,0,0"), "head"},
      {IFacialMocapPacket(many, "0,0,0,0,0,0"), "more than 256 parts"}};
  uint64_t count = 0;
  for (const auto& [packet, problem] : cases) {
    phone.Send(packet);
    EXPECT_FALSE(phone.Poll());
    EXPECT_EQ(phone.Counts().malformed, ++count) << packet;
    EXPECT_NE(phone.Counts().last_problem.find(problem), std::string::npos)
        << phone.Counts().last_problem;
  }
  phone.Send(IFacialMocapPacket("jawOpen-50|jawLeft-|jawRight-900|x|", "0,0,0,0,0,0"));
  ASSERT_TRUE(phone.Poll());
  EXPECT_FLOAT_EQ(JawOpen(phone.frame), 0.5f);
  EXPECT_EQ(NotesOf(phone.Counts()), "dropped: jawLeft (1), jawRight (1), x (1)");
}

struct LiveLink {
  std::unique_ptr<LiveSource> source = OpenLiveSource("livelink://:0");
  LiveFrame frame;
  bool Poll(const std::string& packet) {
    EXPECT_TRUE(UdpSocket::ConnectTo(ParseDriveAddress(test::AddressOf(*source))).Send(packet));
    return source->Poll(0, frame);
  }
};

// Unreal's order: 17 jawOpen, 15 jawLeft, 16 jawRight; head's yaw, pitch and roll from 52 on.
TEST(LiveLinkSource, NumbersAreInUnrealsOrder) {
  LiveLink link;
  std::array<float, 61> numbers{};
  numbers[17] = 0.5f;
  numbers[15] = 1;
  numbers[4] = 1;
  numbers[52] = 0.1f;
  ASSERT_TRUE(link.Poll(LiveLinkPacket(numbers))) << link.source->Counts().last_problem;
  EXPECT_FLOAT_EQ(JawOpen(link.frame), 0.5f);
  EXPECT_FLOAT_EQ(link.frame.params.pose[2][1], 0.1f);  // to the left
  EXPECT_FLOAT_EQ(link.frame.params.pose[3][0], -0.3f);
  EXPECT_NEAR(link.frame.params.pose[0][1], -0.1f, 1e-6f);
  numbers = {};
  numbers[16] = 1;
  numbers[53] = 0.1f;
  ASSERT_TRUE(link.Poll(LiveLinkPacket(numbers)));
  EXPECT_FLOAT_EQ(link.frame.params.pose[2][1], -0.1f);
  EXPECT_NEAR(link.frame.params.pose[0][0], -0.1f, 1e-6f);
  numbers = {};
  numbers[54] = 0.1f;
  ASSERT_TRUE(link.Poll(LiveLinkPacket(numbers)));
  EXPECT_NEAR(link.frame.params.pose[0][2], 0.1f, 1e-6f);
  EXPECT_FALSE(link.Poll(LiveLinkPacket({}, false)));
  EXPECT_EQ(link.source->Counts().unused.messages.Of("no face"), 1u);
  EXPECT_EQ(link.source->Counts().unusable, 1u);
}

TEST(LiveLinkSource, BadPacketsAreNamedAndABadScoreCostsOnlyItself) {
  LiveLink link;
  const std::string good = LiveLinkPacket({});
  std::array<float, 61> turned{}, bad_scores{};
  turned[52] = 7;
  std::string seven = good, many = good;
  seven[0] = 7;
  many[good.size() - 61 * 4 - 1] = 62;
  const std::pair<std::string, std::string> cases[] = {
      {seven, "version: found 7, expected 6"},
      {many, "count: found 62, expected 61"},
      {good.substr(0, good.size() - 1), "ends within the numbers"},
      {good.substr(0, 20), "ends within the names"},
      {std::string("\x06\xff\xff\xff\xff", 5), "ends within the names"},
      {LiveLinkPacket(turned), "head yaw: found 7"}};
  uint64_t count = 0;
  for (const auto& [packet, problem] : cases) {
    EXPECT_FALSE(link.Poll(packet));
    EXPECT_EQ(link.source->Counts().malformed, ++count);
    EXPECT_NE(link.source->Counts().last_problem.find(problem), std::string::npos)
        << link.source->Counts().last_problem;
  }
  bad_scores[17] = 0.5f;
  bad_scores[14] = kNan;
  bad_scores[15] = 40;
  ASSERT_TRUE(link.Poll(LiveLinkPacket(bad_scores)));
  EXPECT_FLOAT_EQ(JawOpen(link.frame), 0.5f);
  EXPECT_EQ(link.source->Counts().unused.dropped.Text(), "jawForward (1), jawLeft (1)");
}

// Two turns at once: to the side first, as a head on a neck does.
TEST(PhoneFrame, HeadsTurnToTheSideFirst) {
  const math::AxisAngle turn = TurnOf({0.3f, 1.2f, 0});
  const math::Quat<float> q = math::QuatOfAxisAngle(turn);
  const float y = 2 * (q.y * q.z - q.w * q.x), up = 1 - 2 * (q.x * q.x + q.z * q.z);
  EXPECT_NEAR(y, -std::sin(0.3f), 1e-5f);  // where the face looks
  EXPECT_NEAR(up, std::cos(0.3f), 1e-5f);  // no lean comes of it
}

TEST(PhoneDrives, QueriesFlipAxesAndErrorsNameTheDrive) {
  Phone phone("vts", "?flip=yz");
  phone.Send(VtsPacket("", {10, 0, 0}));
  ASSERT_TRUE(phone.Poll());
  ExpectTurn(phone.frame, 0, 10, 0);
  phone.Send(VtsPacket("", {0, 10, 0}));
  ASSERT_TRUE(phone.Poll());
  ExpectTurn(phone.frame, 10, 0, 0);
  const auto expect = [](const std::string& drive, const std::string& problem) {
    ExpectError([&] { OpenLiveSource(drive); }, {drive, problem});
  };
  expect("vts://", "host: is missing");
  expect("ifacialmocap://:49983", "host: is missing");
  expect("vts://127.0.0.1:0", "port: found 0");
  expect("vts://127.0.0.1?flip=w", "?flip=AXES");
  expect("vts://127.0.0.1?flip=x&map=m", "?flip=AXES");
  expect("udp://:0?flip=x", "expected udp://HOST:PORT?matrix=FILE");
  ExpectError([] { OpenLiveSource("vts://127.0.0.1?flip=x&matrix=none.npz"); }, {"none.npz"});
}

}  // namespace
}  // namespace cosplat
