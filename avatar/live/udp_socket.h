// A non-blocking UDP socket, bound to receive or connected to send.
#pragma once

#include <array>
#include <cstddef>
#include <string>

namespace cosplat {

// The parts of "udp://HOST:PORT" and similar addresses.
struct DriveAddress {
  std::string drive;   // the whole text, for errors
  std::string scheme;  // "udp"
  std::string host;    // a name or address, IPv6 without brackets; loopback if omitted
  int port = 0;        // 0 to 65535
  std::string query;   // after the first '?'; "" if there is none
};

// SCHEME://[HOST]:PORT[?QUERY], IPv6 in brackets; of phones SCHEME://HOST[:PORT]. Throws Error
// naming the drive.
DriveAddress ParseDriveAddress(const std::string& drive);

// "127.0.0.1:9500", "[::1]:9500".
std::string HostAndPort(const std::string& host, int port);

// Where a datagram came from.
struct Peer {
  std::array<unsigned char, 16> host{};  // IPv4: the first four
  int port = 0;
  bool ipv6 = false;
  bool operator==(const Peer&) const = default;
};
std::string ToString(const Peer& peer);

class UdpSocket {
 public:
  // Port 0 lets the operating system choose. Both throw Error naming the drive.
  static UdpSocket Listen(const DriveAddress& address);
  static UdpSocket ConnectTo(const DriveAddress& address);
  ~UdpSocket();
  UdpSocket(UdpSocket&& other) noexcept;
  UdpSocket& operator=(UdpSocket&&) = delete;

  // Returns the size of the next datagram, or -1 if there is none. A datagram larger than
  // `capacity` is truncated. from: its sender.
  long Receive(char* buffer, size_t capacity, Peer& from);
  // Returns false when the packet was not sent, for example because nobody listens. Even if it
  // returns true, the datagram may get lost.
  bool Send(const std::string& packet);
  // What ConnectTo connected it to, as it was resolved.
  Peer RemoteAddress() const;
  // The address that it receives on, with the actual port: "127.0.0.1:9500".
  std::string LocalAddress() const;
  // If it receives on all networks (0.0.0.0, ::): what a sender on one of them is to be told, IPv4
  // addresses of this machine with the port, joined by " or ". Otherwise "".
  std::string AddressesForSenders() const;

 private:
  explicit UdpSocket(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace cosplat
