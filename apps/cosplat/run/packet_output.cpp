#include "apps/cosplat/run/packet_output.h"

#include <cstdio>

#include "avatar/live/face_scores.h"
#include "avatar/live/vmc_frame.h"
#include "splat/base/error.h"

namespace cosplat {

PacketOutput::PacketOutput(const std::string& to) {
  if (to.empty()) return;
  const DriveAddress address = ParseDriveAddress(to);
  is_vmc_ = address.scheme == "vmc";
  if ((address.scheme != "udp" && !is_vmc_) || address.port == 0)
    throw Error("--to", "found '" + to + "', expected udp://HOST:PORT or vmc://HOST:PORT");
  socket_.emplace(UdpSocket::ConnectTo(address));
}

std::string PacketOutput::PacketOf(const JsonFrame& frame, const BlendshapeMap& map) const {
  if (!is_vmc_) return WriteJsonFrame(frame);
  const FlameParams& face = frame.params;
  return WriteVmcFrame(
      frame.blendshapes ? *frame.blendshapes : ScoresOf(map, face), face.pose[0], face.pose[1]);
}

bool PacketOutput::Write(const std::string& packet) {
  if (socket_) return socket_->Send(packet);
  if (std::fputs((packet + "\n").c_str(), stdout) < 0 || std::fflush(stdout) != 0)
    throw Error("standard output", "cannot be written");
  return true;
}

}  // namespace cosplat
