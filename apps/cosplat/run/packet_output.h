// Frames of a face to who shows it: lines on standard output, or datagrams (`send`, `webcam`).
#pragma once

#include <optional>
#include <string>

#include "avatar/live/json_frame.h"
#include "avatar/live/udp_socket.h"
#include "avatar/model/blendshape_map.h"

namespace cosplat {

class PacketOutput {
 public:
  // to: udp://HOST:PORT or vmc://HOST:PORT; "": standard output. Throws Error naming --to.
  explicit PacketOutput(const std::string& to);
  // map: by which VMC carries FLAME parameters of a frame that has no scores.
  std::string PacketOf(const JsonFrame& frame, const BlendshapeMap& map) const;
  // Returns false if the packet was lost before it was sent. Throws Error if standard output cannot
  // be written.
  bool Write(const std::string& packet);

 private:
  std::optional<UdpSocket> socket_;
  bool is_vmc_ = false;
};

}  // namespace cosplat
