#include <array>

#include "avatar/live/packet_input.h"
#include "avatar/live/udp_socket.h"

namespace cosplat {
namespace {

// At most a few milliseconds. Further packets wait in the system's buffer or are lost there.
constexpr int kMaxReadPerCall = 4096;

class UdpInput : public PacketInput {
 public:
  explicit UdpInput(const DriveAddress& address)
      : socket_(UdpSocket::Listen(address)),
        description_(address.scheme + "://" + socket_.LocalAddress()) {}

  void Receive(NewestPackets& packets, LiveCounts& counts) override {
    for (int i = 0; i < kMaxReadPerCall; ++i) {
      const long size = socket_.Receive(buffer_.data(), buffer_.size());
      if (size < 0) return;
      if (size_t(size) > buffer_.size()) {
        CountOversize(description_, size_t(size), counts);
      } else {
        CountFlooded(description_, packets.Push({buffer_.data(), size_t(size)}), counts);
      }
    }
  }
  bool Ended() const override { return false; }
  std::string Description() const override { return description_; }

 private:
  UdpSocket socket_;
  std::string description_;
  std::array<char, kMaxPacketBytes> buffer_;
};

}  // namespace

std::unique_ptr<PacketInput> OpenUdpInput(const DriveAddress& address) {
  return std::make_unique<UdpInput>(address);
}

void CountOversize(const std::string& description, size_t bytes, LiveCounts& counts) {
  ++counts.oversize;
  counts.last_problem = description + ": a packet of " + std::to_string(bytes) +
                        " bytes, at most " + std::to_string(kMaxPacketBytes) + " are accepted";
}

void CountFlooded(const std::string& description, size_t packets, LiveCounts& counts) {
  if (packets == 0) return;
  counts.flooded += packets;
  counts.last_problem =
      description + ": too many packets between two polls; the oldest were dropped";
}

}  // namespace cosplat
