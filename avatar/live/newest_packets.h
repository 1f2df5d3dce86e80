// The newest packets of a poll, in the order in which they came.
//
// UdpInput, LineInput -> NewestPackets -> JsonSource, VmcSource. It bounds what one poll looks at:
// a flood pushes out its own oldest packets.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cosplat {

class NewestPackets {
 public:
  explicit NewestPackets(size_t most) : slots_(most) {}

  // False when that pushed out the oldest.
  bool Push(std::string_view packet) {
    const bool full = count_ == slots_.size();
    if (full) first_ = (first_ + 1) % slots_.size();
    if (!full) ++count_;
    slots_[(first_ + count_ - 1) % slots_.size()].assign(packet);
    return !full;
  }
  size_t size() const { return count_; }
  const std::string& operator[](size_t i) const { return slots_[(first_ + i) % slots_.size()]; }
  void Clear() { count_ = 0; }

 private:
  std::vector<std::string> slots_;  // keep their memory
  size_t first_ = 0, count_ = 0;
};

}  // namespace cosplat
