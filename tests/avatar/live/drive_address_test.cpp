#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "avatar/live/packet_input.h"
#include "avatar/live/udp_socket.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using test::ExpectError;

TEST(DriveAddress, IsTakenApart) {
  const DriveAddress told = ParseDriveAddress("vmc://0.0.0.0:39539?matrix=a?b=c.npz");
  EXPECT_EQ(told.scheme, "vmc");
  EXPECT_EQ(told.host, "0.0.0.0");
  EXPECT_EQ(told.port, 39539);
  EXPECT_EQ(told.query, "matrix=a?b=c.npz");
  EXPECT_EQ(ParseDriveAddress("udp://[::1]:9500").host, "::1");
  // Of phones, the app's usual port.
  EXPECT_EQ(ParseDriveAddress("vts://192.168.1.20").port, 21412);
  EXPECT_EQ(ParseDriveAddress("vts://192.168.1.20:5000").port, 5000);
  EXPECT_EQ(ParseDriveAddress("ifacialmocap://[::1]").port, 49983);
  EXPECT_EQ(ParseDriveAddress("livelink://").port, 11111);
  EXPECT_EQ(ParseDriveAddress("livelink://").host, "127.0.0.1");
  EXPECT_EQ(ParseDriveAddress("livelink://0.0.0.0").host, "0.0.0.0");
  EXPECT_EQ(HostAndPort("::1", 9500), "[::1]:9500");
}

TEST(DriveAddress, IsLoopbackUnlessToldOtherwise) {
  EXPECT_EQ(ParseDriveAddress("udp://:9500").host, "127.0.0.1");
  const std::string description = OpenUdpInput(ParseDriveAddress("udp://:0"))->Description();
  EXPECT_EQ(description.rfind("udp://127.0.0.1:", 0), 0u) << description;
}

// Someone has to type it into a phone's app.
TEST(DriveAddress, OfAllNetworksIsSaidAsSendersNeedIt) {
  UdpSocket all = UdpSocket::Listen(ParseDriveAddress("udp://0.0.0.0:0"));
  const std::string local = all.LocalAddress(), senders = all.AddressesForSenders();
  if (senders.empty()) GTEST_SKIP() << "this machine has no network but its own";
  const std::string first = senders.substr(0, senders.find(" or "));
  EXPECT_EQ(first.substr(first.rfind(':')), local.substr(local.rfind(':')));
  UdpSocket phone = UdpSocket::ConnectTo(ParseDriveAddress("udp://" + first));
  ASSERT_TRUE(phone.Send("hello"));
  char received[5];
  Peer from;
  long size = -1;
  for (int i = 0; i < 1000 && size < 0; ++i) {
    size = all.Receive(received, sizeof(received), from);
    if (size < 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(std::string(received, size_t(std::max(0l, size))), "hello");
  EXPECT_NE(OpenUdpInput(ParseDriveAddress("udp://0.0.0.0:0"))->Description().find("for senders: "),
            std::string::npos);
  EXPECT_EQ(UdpSocket::Listen(ParseDriveAddress("udp://:0")).AddressesForSenders(), "");
}

TEST(DriveAddress, ErrorsNameTheDrive) {
  const auto expect = [](const std::string& drive, const std::string& problem) {
    ExpectError([&] { OpenLiveSource(drive); }, {drive, problem});
  };
  expect("udp://", "port");
  expect("udp://localhost", "port");
  expect("udp://[::1]", "port");
  expect("udp://:65536", "65536");
  expect("udp://:-1", "-1");
  expect("udp://:12x", "12x");
  expect("udp://::1:9500", "brackets");
  expect("udp://no such host:9500", "no such host");
  expect("udp://192.0.2.1:9500", "cannot listen");  // an address that no machine has (RFC 5737)
  expect("tcp://localhost:9500", "udp://HOST:PORT");
}

TEST(DriveAddress, APortThatIsTakenIsSaid) {
  const std::string taken = OpenUdpInput(ParseDriveAddress("udp://:0"))->Description();
  const auto first = OpenLiveSource(taken);
  ExpectError([&] { OpenLiveSource(taken); }, {taken, "already in use"});
}

}  // namespace
}  // namespace cosplat
