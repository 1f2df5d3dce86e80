// A UDP socket that never waits: bound to receive, or connected to send.
#pragma once

#include <cstddef>
#include <string>

#include "avatar/live/drive_address.h"

namespace cosplat {

class UdpSocket {
 public:
  // Port 0 lets the system choose. Both throw Error naming the drive.
  static UdpSocket Listen(const DriveAddress& address);
  static UdpSocket ConnectTo(const DriveAddress& address);
  ~UdpSocket();
  UdpSocket(UdpSocket&& other) noexcept;
  UdpSocket& operator=(UdpSocket&&) = delete;

  // The next datagram's size, which may exceed `capacity` (it is cut off then); -1: there is none.
  long Receive(char* buffer, size_t capacity);
  // False when it was not handed on, such as while nobody listens: datagrams may get lost anyway.
  bool Send(const std::string& packet);
  // Where it receives, with the port that the system chose: "127.0.0.1:9500".
  std::string LocalAddress() const;

 private:
  explicit UdpSocket(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace cosplat
