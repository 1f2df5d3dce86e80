#include <algorithm>
#include <array>
#include <optional>

#include "avatar/live/packet_input.h"
#include "avatar/live/udp_socket.h"

namespace cosplat {
namespace {

// At most a few milliseconds. Further packets wait in the system's buffer or are lost there.
constexpr int kMaxReadPerCall = 4096;

// Notices that two senders take turns: one comes back after another has sent. A program that is
// restarted, or uses a new port for each packet, does not.
class SenderWatch {
 public:
  // Returns true if `peer` comes back.
  bool Saw(const Peer& peer) {
    if (count_ > 0 && peer == recent_[0]) return false;
    const auto end = recent_.begin() + count_;
    const auto found = std::find(recent_.begin(), end, peer);
    const bool returned = found != end;
    if (!returned && count_ < recent_.size()) ++count_;
    std::rotate(recent_.begin(),
                returned ? found : recent_.begin() + count_ - 1,
                returned ? found + 1 : recent_.begin() + count_);
    recent_[0] = peer;
    return returned;
  }
  std::string Text() const { return ToString(recent_[0]) + " and " + ToString(recent_[1]); }

 private:
  std::array<Peer, 4> recent_;  // the last one first
  size_t count_ = 0;
};

class UdpInput : public PacketInput {
 public:
  UdpInput(UdpSocket socket, std::string description, const std::optional<Peer>& only_from)
      : socket_(std::move(socket)), description_(std::move(description)), only_from_(only_from) {}

  void Receive(NewestPackets& packets, LiveCounts& counts) override {
    Peer from;
    for (int i = 0; i < kMaxReadPerCall; ++i) {
      const long size = socket_.Receive(buffer_.data(), buffer_.size(), from);
      if (size < 0) return;
      ++counts.packets;
      if (only_from_ && (from.host != only_from_->host || from.ipv6 != only_from_->ipv6)) {
        ++counts.unusable;
        from.port = 0;  // others change theirs, and names are kept
        counts.unused.messages.Count("from " + ToString(from));
        continue;
      }
      if (senders_.Saw(from) && counts.senders.empty()) counts.senders = senders_.Text();
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
  SenderWatch senders_;
  std::string description_;
  std::optional<Peer> only_from_;
  std::array<char, kMaxPacketBytes> buffer_;
};

}  // namespace

std::unique_ptr<PacketInput> OpenUdpInput(const DriveAddress& address) {
  UdpSocket socket = UdpSocket::Listen(address);
  std::string description = address.scheme + "://" + socket.LocalAddress();
  if (const std::string own = socket.AddressesForSenders(); !own.empty())
    description += " (for senders: " + own + ")";
  return std::make_unique<UdpInput>(std::move(socket), std::move(description), std::nullopt);
}

std::unique_ptr<PacketInput> OpenUdpInput(UdpSocket socket,
                                          const std::string& description,
                                          const Peer& only_from) {
  return std::make_unique<UdpInput>(std::move(socket), description, only_from);
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
