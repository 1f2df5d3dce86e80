// "udp://HOST:PORT" and its like, taken apart.
#pragma once

#include <string>

namespace cosplat {

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

}  // namespace cosplat
