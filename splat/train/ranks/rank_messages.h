// Messages between ranks (splat/train/ranks/ranks.h) in a stream's memory: on the host as they are,
// from and to a device by way of host memory.
#pragma once

#include <vector>

#include "splat/train/ranks/ranks.h"

namespace cosplat {

class RankMessages {
 public:
  explicit RankMessages(Ranks& ranks) : ranks_(ranks) {}

  // Sends to[r], which is in the stream's memory, to rank r, and receives; what is for this rank is
  // not sent. All ranks call it.
  void Exchange(const std::vector<Message>& to, Stream& stream);
  // The same, with one message for all others.
  void ExchangeWithAll(const Message& message, Stream& stream);
  // The message received in the last exchange, in the stream's memory; the own one is empty.
  const Message& From(size_t rank) const { return from_[rank]; }

  void Release(Stream& stream);
  size_t allocated_bytes() const;  // bytes of the stream's memory

 private:
  void Send(const std::vector<View<const uint32_t>>& to, Stream& stream);

  Ranks& ranks_;
  std::vector<Message> from_;
  std::vector<Message> host_to_, host_from_;  // of a device's
};

}  // namespace cosplat
