#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>

#include "avatar/live/packet_input.h"

namespace cosplat {
namespace {

constexpr size_t kMaxReadPerCall = 512 * 1024;

class LineInput : public PacketInput {
 public:
  LineInput(int descriptor, std::string description)
      : descriptor_(descriptor), description_(std::move(description)) {}

  void Receive(NewestPackets& packets, LiveCounts& counts) override {
    for (size_t total = 0; !ended_ && total < kMaxReadPerCall && IsReady();) {
      const ssize_t size = read(descriptor_, buffer_.data(), buffer_.size());
      if (size < 0 && (errno == EINTR || errno == EAGAIN)) return;
      ended_ = size <= 0;
      std::string_view bytes(buffer_.data(), ended_ ? 0 : size_t(size));
      total += bytes.size();
      for (size_t end; (end = bytes.find('\n')) != bytes.npos; bytes.remove_prefix(end + 1)) {
        Append(bytes.substr(0, end));
        FinishLine(packets, counts);
      }
      Append(bytes);
      if (ended_) FinishLine(packets, counts);
    }
  }
  bool Ended() const override { return ended_; }
  std::string Description() const override { return description_; }

 private:
  bool IsReady() const {
    pollfd request{descriptor_, POLLIN, 0};
    return poll(&request, 1, 0) > 0;  // also when the other end was closed
  }

  // Stores at most kMaxPacketBytes of a line, but counts all its bytes.
  void Append(std::string_view bytes) {
    line_bytes_ += bytes.size();
    line_.append(bytes.substr(0, kMaxPacketBytes - line_.size()));
  }

  void FinishLine(NewestPackets& packets, LiveCounts& counts) {
    const bool blank = line_.find_first_not_of(" \t\r") == std::string::npos;
    counts.packets += !blank || line_bytes_ > kMaxPacketBytes;
    if (line_bytes_ > kMaxPacketBytes) {
      CountOversize(description_, line_bytes_, counts);
    } else if (!blank) {
      CountFlooded(description_, packets.Push(line_), counts);
    }
    line_.clear();
    line_bytes_ = 0;
  }

  int descriptor_;
  std::string description_;
  std::string line_;  // the incomplete line read so far
  size_t line_bytes_ = 0;
  bool ended_ = false;
  std::array<char, 64 * 1024> buffer_;
};

}  // namespace

std::unique_ptr<PacketInput> OpenLineInput(int descriptor, const std::string& description) {
  return std::make_unique<LineInput>(descriptor, description);
}

}  // namespace cosplat
