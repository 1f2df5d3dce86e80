#include "apps/cosplat/run/relay.h"

#include <gtest/gtest.h>

#include "avatar/live/json_frame.h"
#include "avatar/live/udp_socket.h"

namespace cosplat {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPatience{2000};

TEST(Relay, EachReaderGetsTheNewestFrame) {
  auto source = OpenLiveSource("udp://:0");
  UdpSocket sender = UdpSocket::ConnectTo(ParseDriveAddress(source->Description()));
  Relay relay(std::move(source), 2);
  const auto send = [&](int number) {
    ASSERT_TRUE(sender.Send(R"({"seq": )" + std::to_string(number) +
                            R"(, "expression": [0.5, 0.25, 9], "jaw": [0.1, 0, 0]})"));
  };
  uint64_t first = 0, second = 0;
  send(1);
  const JsonFrame frame = ParseJsonFrame("relay", relay.Next(first, kPatience));
  EXPECT_EQ(frame.params.expression, (std::vector<float>{0.5f, 0.25f}));
  EXPECT_FLOAT_EQ(frame.params.pose[2][0], 0.1f);
  // Nothing newer yet, but another reader has not seen it.
  EXPECT_EQ(relay.Next(first, milliseconds(50)), "");
  EXPECT_NE(relay.Next(second, kPatience), "");
  send(2);
  EXPECT_NE(relay.Next(first, kPatience), "");
  EXPECT_EQ(first, 2u);
}

}  // namespace
}  // namespace cosplat
