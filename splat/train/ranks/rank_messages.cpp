#include "splat/train/ranks/rank_messages.h"

namespace cosplat {

void RankMessages::Exchange(const std::vector<Message>& to, Stream& stream) {
  if (stream.on_host()) return Send({to.begin(), to.end()}, stream);
  host_to_.resize(to.size());
  for (size_t r = 0; r < to.size(); ++r) {
    if (r == ranks_.rank()) continue;
    host_to_[r].RefillForReadback(to[r].size(), stream);
    to[r].Download(host_to_[r].data(), stream);
  }
  stream.Wait();
  Send({host_to_.begin(), host_to_.end()}, stream);
}

void RankMessages::ExchangeWithAll(const Message& message, Stream& stream) {
  View<const uint32_t> sent = message;
  if (!stream.on_host()) {
    host_to_.resize(ranks_.size());
    Message& of_host = host_to_[ranks_.rank()];
    of_host.RefillForReadback(message.size(), stream);
    message.Download(of_host.data(), stream);
    stream.Wait();
    sent = of_host;
  }
  Send(std::vector<View<const uint32_t>>(ranks_.size(), sent), stream);
}

void RankMessages::Send(const std::vector<View<const uint32_t>>& to, Stream& stream) {
  if (stream.on_host()) return ranks_.Exchange(to, from_);
  ranks_.Exchange(to, host_from_);
  from_.resize(ranks_.size());
  for (size_t r = 0; r < from_.size(); ++r) {
    from_[r].Refill(r == ranks_.rank() ? 0 : host_from_[r].size(), stream);
    // What it is copied from stays until the next exchange, which waits first.
    if (!from_[r].empty())
      stream.Upload(from_[r].data(), host_from_[r].data(), from_[r].size() * sizeof(uint32_t));
  }
}

void RankMessages::Release(Stream& stream) {
  stream.Wait();
  for (auto* messages : {&from_, &host_to_, &host_from_}) messages->clear();
}

size_t RankMessages::allocated_bytes() const {
  size_t bytes = 0;
  for (const Message& message : from_) bytes += AllocatedBytes(message);
  return bytes;
}

}  // namespace cosplat
