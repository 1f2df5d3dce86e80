// A UDP socket that never waits: bound to receive, or connected to send.
#pragma once

#include <cstddef>
#include <string>

namespace cosplat {

// "udp://HOST:PORT" and its like, taken apart.
struct DriveAddress {
  std::string drive;   // as given, for errors
  std::string scheme;  // "udp"
  std::string host;    // a name or address, IPv6 without brackets; loopback where none was given
  int port = 0;        // 0 to 65535
  std::string query;   // after the first '?'; "" if there is none
};

// SCHEME://[HOST]:PORT[?QUERY], IPv6 in brackets. Throws Error naming the drive.
DriveAddress ParseDriveAddress(const std::string& drive);

// "127.0.0.1:9500", "[::1]:9500".
std::string HostAndPort(const std::string& host, int port);

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
