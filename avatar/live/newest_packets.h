// The newest packets of a poll, in order of arrival.
//
// UdpInput, LineInput -> NewestPackets -> JsonSource, VmcSource, PhoneSource. Bounds the work of
// one poll: when too many packets arrive, the oldest are discarded.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cosplat {

class NewestPackets {
 public:
  explicit NewestPackets(size_t max) : slots_(max) {}

  // Returns the number of older packets discarded.
  size_t Push(std::string_view packet) {
    size_t pushed_out = 0;
    for (; count_ > 0 && (count_ == slots_.size() || bytes_ + packet.size() > kMaxBytes);
         ++pushed_out)
      PopOldest();
    slots_[(first_ + count_) % slots_.size()].assign(packet);
    ++count_;
    bytes_ += packet.size();
    return pushed_out;
  }
  size_t size() const { return count_; }
  const std::string& operator[](size_t i) const { return slots_[(first_ + i) % slots_.size()]; }
  void Clear() { count_ = bytes_ = 0; }

 private:
  // For all packets together: a parser needs a few milliseconds for this.
  static constexpr size_t kMaxBytes = 512 * 1024;

  void PopOldest() {
    bytes_ -= slots_[first_].size();
    first_ = (first_ + 1) % slots_.size();
    --count_;
  }

  std::vector<std::string> slots_;  // a ring; strings keep their memory
  size_t first_ = 0, count_ = 0, bytes_ = 0;
};

}  // namespace cosplat
