// Packets from somewhere, without waiting for them: a UDP socket, lines of standard input.
//
// UdpInput, LineInput -> JsonSource, VmcSource.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "avatar/live/blendshape_matrix.h"
#include "avatar/live/newest_packets.h"
#include "avatar/live/source.h"
#include "avatar/live/udp_socket.h"

namespace cosplat {

// Longer packets and lines are dropped: FLAME's 400 coefficients with 20 digits each are half of
// it.
constexpr size_t kMaxPacketBytes = 16 * 1024;

class PacketInput {
 public:
  virtual ~PacketInput() = default;
  // Adds what has come in since the last call, never waits. Counts what is oversize and flooded.
  virtual void Receive(NewestPackets& packets, LiveCounts& counts) = 0;
  virtual bool Ended() const = 0;
  virtual std::string Description() const = 0;
};

// Counts and describes a packet that is dropped.
void CountOversize(const std::string& description, size_t bytes, LiveCounts& counts);
void CountFlooded(const std::string& description, size_t packets, LiveCounts& counts);

// A packet per datagram. Reads at most 4096 per call. Throws Error when it cannot listen there.
std::unique_ptr<PacketInput> OpenUdpInput(const DriveAddress& address);

// A packet per line of the descriptor, which is neither closed nor made non-blocking, since others
// may share it. Reads at most half a megabyte per call. Blank lines are skipped.
std::unique_ptr<PacketInput> OpenLineInput(int descriptor, const std::string& description);

// FLAME parameters as lines of JSON, live: docs/live-input.md.
//
// PacketInput -> ParseJsonFrame -> JsonSource (by OpenLiveSource) -> LiveFrame.

std::unique_ptr<LiveSource> OpenJsonSource(std::unique_ptr<PacketInput> input,
                                           const LiveSourceOptions& options);

// Blendshapes of a face tracker by the Virtual Motion Capture protocol, live: docs/live-input.md.
//
// PacketInput -> ParseOsc -> VmcSource (by OpenLiveSource), with a BlendshapeMatrix -> LiveFrame.

std::unique_ptr<LiveSource> OpenVmcSource(std::unique_ptr<PacketInput> input,
                                          BlendshapeMatrix matrix,
                                          const LiveSourceOptions& options);

}  // namespace cosplat
