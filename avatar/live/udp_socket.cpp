#include "avatar/live/udp_socket.h"

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "splat/base/error.h"

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

}  // namespace

UdpSocket UdpSocket::Listen(const DriveAddress& address) {
  const AddressList list = Resolve(address);
  const addrinfo& target = Preferred(*list);
  UdpSocket result(OpenDescriptor(address, target));
  setsockopt(result.descriptor_, SOL_SOCKET, SO_RCVBUF, &kReceiveBytes, sizeof(kReceiveBytes));
  if (bind(result.descriptor_, target.ai_addr, target.ai_addrlen) != 0)
    throw Error(address.drive,
                std::string("cannot listen on this address: ") + std::strerror(errno));
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

long UdpSocket::Receive(char* buffer, size_t capacity) {
  long size;
  do {
    size = recv(descriptor_, buffer, capacity, MSG_DONTWAIT | MSG_TRUNC);
  } while (size < 0 && errno == EINTR);
  return size;
}

bool UdpSocket::Send(const std::string& packet) {
  return send(descriptor_, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL) ==
         long(packet.size());
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

}  // namespace cosplat
