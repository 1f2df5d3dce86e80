#include "avatar/live/packet_input.h"

namespace cosplat {

void CountOversize(const std::string& description, size_t bytes, LiveCounts& counts) {
  ++counts.oversize;
  counts.last_problem = description + ": a packet of " + std::to_string(bytes) +
                        " bytes, at most " + std::to_string(kMaxPacketBytes) + " are taken";
}

void CountFlooded(const std::string& description, size_t packets, LiveCounts& counts) {
  if (packets == 0) return;
  counts.flooded += packets;
  counts.last_problem = description + ": more packets at once than are looked at";
}

}  // namespace cosplat
