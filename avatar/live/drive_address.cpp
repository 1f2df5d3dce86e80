#include <algorithm>
#include <iterator>

#include "avatar/live/packet_input.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// What a drive is to an address without a port, and without a host.
struct UsualAddress {
  const char* name;
  int usual_port;      // of the apps
  bool asks_the_host;  // a phone's address, which cannot be left out
};
constexpr UsualAddress kUsualAddresses[] = {
    {"vts", 21412, true}, {"ifacialmocap", 49983, true}, {"livelink", 11111, false}};

int ParsePort(const std::string& drive, const std::string& text) {
  const int port = NumberOf<int>(text).value_or(-1);
  if (port < 0 || port > 65535)
    throw Error(drive, "port", "found '" + text + "', expected 0 to 65535");
  return port;
}

}  // namespace

DriveAddress ParseDriveAddress(const std::string& drive) {
  const size_t scheme_end = drive.find("://");
  if (scheme_end == std::string::npos) throw Error(drive, "expected SCHEME://HOST:PORT");
  DriveAddress address;
  address.drive = drive;
  address.scheme = drive.substr(0, scheme_end);
  std::string rest = drive.substr(scheme_end + 3);
  if (const size_t mark = rest.find('?'); mark != std::string::npos) {
    address.query = rest.substr(mark + 1);
    rest.resize(mark);
  }
  const auto scheme = std::find_if(std::begin(kUsualAddresses),
                                   std::end(kUsualAddresses),
                                   [&](const UsualAddress& s) { return s.name == address.scheme; });
  const bool known = scheme != std::end(kUsualAddresses);
  const size_t colon = rest.rfind(':');
  const size_t bracket = rest.rfind(']');
  const bool has_port =
      colon != std::string::npos && (bracket == std::string::npos || colon > bracket);
  if (!has_port && !known)
    throw Error(drive, "port", "is missing: expected " + address.scheme + "://HOST:PORT");
  address.port = has_port ? ParsePort(drive, rest.substr(colon + 1)) : scheme->usual_port;
  address.host = has_port ? rest.substr(0, colon) : rest;
  if (address.host.empty() && known && scheme->asks_the_host)
    throw Error(
        drive, "host", "is missing: expected the phone's, " + address.scheme + "://192.168.1.20");
  if (address.host.starts_with('[') && address.host.ends_with(']'))
    address.host = address.host.substr(1, address.host.size() - 2);
  else if (address.host.find(':') != std::string::npos)
    throw Error(drive, "host", "IPv6 addresses are written in brackets: [::1]:9500");
  if (address.host.empty()) address.host = "127.0.0.1";
  return address;
}

std::string HostAndPort(const std::string& host, int port) {
  const bool ipv6 = host.find(':') != std::string::npos;
  return (ipv6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

}  // namespace cosplat
