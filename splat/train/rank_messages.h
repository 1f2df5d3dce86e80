// Messages between ranks (splat/train/ranks.h) in a stream's memory: on the host as they are, from
// and to a device by way of host memory.
#pragma once

#include <vector>

#include "splat/train/ranks.h"

namespace cosplat {

class RankMessages {
 public:
  explicit RankMessages(Ranks& ranks) : ranks_(ranks) {}

  // In the memory of the stream that fills it; the own one is not sent.
  Message& To(size_t rank) {
    to_.resize(ranks_.size());
    return to_[rank];
  }
  // Sends what is for each rank, and receives. All ranks call it.
  void Exchange(Stream& stream);
  // The same, with this rank's own message for all.
  void ExchangeWithAll(Stream& stream);
  // In the stream's memory; the own one is empty.
  Message& From(size_t rank) { return from_[rank]; }

  void Release(Stream& stream);
  size_t held() const;  // bytes

 private:
  void Send(const std::vector<View<const uint32_t>>& to, Stream& stream);

  Ranks& ranks_;
  std::vector<Message> to_, from_;
  std::vector<Message> host_to_, host_from_;  // of a device's
};

}  // namespace cosplat
