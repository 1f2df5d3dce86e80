// A live source on loopback and what sends to it.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "avatar/live/source.h"
#include "avatar/live/udp_socket.h"
#include "tests/avatar/live/osc_builder.h"

namespace cosplat::test {

struct LiveConnection {
  std::unique_ptr<LiveSource> source;
  UdpSocket sender;

  explicit LiveConnection(const std::string& scheme, const LiveSourceOptions& options = {})
      : source(OpenLiveSource(scheme + "://:0", options)), sender(Sender()) {}

  // Another one.
  UdpSocket Sender() const { return UdpSocket::ConnectTo(ParseDriveAddress(AddressOf(*source))); }
  void Send(const std::string& packet) { ASSERT_TRUE(sender.Send(packet)); }
  // Whether a frame comes of what has been sent.
  bool Poll(int64_t now_ns = 0) { return source->Poll(now_ns, frame); }
  LiveCounts Counts() const { return source->Counts(); }
  std::string Notes() const { return NotesOf(source->Counts()); }
  // By the general map, which opens by half a radian at a score of 1.
  float JawOpen() const { return 2 * frame.params.pose[2][0]; }

  LiveFrame frame;
};

}  // namespace cosplat::test
