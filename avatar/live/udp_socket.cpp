#include "avatar/live/udp_socket.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// The system may grant less. One second of an unbundled VMC stream is about 4000 small datagrams.
constexpr int kReceiveBytes = 4 << 20;

using AddressList = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

AddressList Resolve(const DriveAddress& address) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int code =
      getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
  if (code != 0) throw Error(address.drive, "host " + address.host, gai_strerror(code));
  return {found, freeaddrinfo};
}

// Prefers IPv4: "localhost" resolves to both, and senders rarely mean ::1.
const addrinfo& Preferred(const addrinfo& list) {
  for (const addrinfo* each = &list; each; each = each->ai_next)
    if (each->ai_family == AF_INET) return *each;
  return list;
}

int OpenDescriptor(const DriveAddress& address, const addrinfo& target) {
  const int descriptor =
      socket(target.ai_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, target.ai_protocol);
  if (descriptor < 0) throw Error(address.drive, std::strerror(errno));
  return descriptor;
}

Peer PeerOf(const sockaddr_storage& storage) {
  Peer peer;
  if (storage.ss_family == AF_INET6) {
    sockaddr_in6 address;
    std::memcpy(&address, &storage, sizeof(address));
    peer.ipv6 = true;
    peer.port = ntohs(address.sin6_port);
    std::memcpy(peer.host.data(), &address.sin6_addr, 16);
  } else {
    sockaddr_in address;
    std::memcpy(&address, &storage, sizeof(address));
    peer.port = ntohs(address.sin_port);
    std::memcpy(peer.host.data(), &address.sin_addr, 4);
  }
  return peer;
}

}  // namespace

UdpSocket UdpSocket::Listen(const DriveAddress& address) {
  const AddressList list = Resolve(address);
  const addrinfo& target = Preferred(*list);
  UdpSocket result(OpenDescriptor(address, target));
  setsockopt(result.descriptor_, SOL_SOCKET, SO_RCVBUF, &kReceiveBytes, sizeof(kReceiveBytes));
  if (bind(result.descriptor_, target.ai_addr, target.ai_addrlen) != 0)
    throw Error(address.drive, Format("cannot listen on this address: {}", std::strerror(errno)));
  return result;
}

UdpSocket UdpSocket::ConnectTo(const DriveAddress& address) {
  const AddressList list = Resolve(address);
  const addrinfo& target = Preferred(*list);
  UdpSocket result(OpenDescriptor(address, target));
  if (connect(result.descriptor_, target.ai_addr, target.ai_addrlen) != 0)
    throw Error(address.drive, std::string("cannot send to this address: ") + std::strerror(errno));
  return result;
}

UdpSocket::UdpSocket(UdpSocket&& other) noexcept : descriptor_(other.descriptor_) {
  other.descriptor_ = -1;
}

UdpSocket::~UdpSocket() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::string ToString(const Peer& peer) {
  char text[INET6_ADDRSTRLEN] = "";
  inet_ntop(peer.ipv6 ? AF_INET6 : AF_INET, peer.host.data(), text, sizeof(text));
  return HostAndPort(text, peer.port);
}

long UdpSocket::Receive(char* buffer, size_t capacity, Peer& from) {
  sockaddr_storage storage{};
  auto* address = reinterpret_cast<sockaddr*>(&storage);
  socklen_t address_size;
  long size;
  do {
    address_size = sizeof(storage);
    size =
        recvfrom(descriptor_, buffer, capacity, MSG_DONTWAIT | MSG_TRUNC, address, &address_size);
  } while (size < 0 && errno == EINTR);
  if (size >= 0) from = PeerOf(storage);
  return size;
}

bool UdpSocket::Send(const std::string& packet) {
  return send(descriptor_, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL) ==
         long(packet.size());
}

Peer UdpSocket::RemoteAddress() const {
  sockaddr_storage storage{};
  socklen_t size = sizeof(storage);
  getpeername(descriptor_, reinterpret_cast<sockaddr*>(&storage), &size);
  return PeerOf(storage);
}

std::string UdpSocket::LocalAddress() const {
  sockaddr_storage storage{};
  socklen_t size = sizeof(storage);
  auto* address = reinterpret_cast<sockaddr*>(&storage);
  char host[NI_MAXHOST] = "", port[NI_MAXSERV] = "0";
  constexpr int kNumeric = NI_NUMERICHOST | NI_NUMERICSERV;
  if (getsockname(descriptor_, address, &size) != 0 ||
      getnameinfo(address, size, host, sizeof(host), port, sizeof(port), kNumeric) != 0)
    return "";
  return HostAndPort(host, std::stoi(port));
}

std::string UdpSocket::AddressesForSenders() const {
  const std::string local = LocalAddress();
  if (!local.starts_with("0.0.0.0:") && !local.starts_with("[::]:")) return "";
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return "";
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> all(first, freeifaddrs);
  std::string addresses;
  for (const ifaddrs* each = first; each; each = each->ifa_next) {
    if (!each->ifa_addr || each->ifa_addr->sa_family != AF_INET) continue;
    if (each->ifa_flags & IFF_LOOPBACK || !(each->ifa_flags & IFF_UP)) continue;
    sockaddr_in address;
    std::memcpy(&address, each->ifa_addr, sizeof(address));
    char host[INET_ADDRSTRLEN];
    inet_ntop(AF_INET, &address.sin_addr, host, sizeof(host));
    addresses +=
        (addresses.empty() ? "" : " or ") + std::string(host) + local.substr(local.rfind(':'));
  }
  return addresses;
}

}  // namespace cosplat
