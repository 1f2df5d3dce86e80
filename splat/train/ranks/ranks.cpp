#include "splat/train/ranks/ranks.h"

#include <algorithm>
#include <cstring>

#include "splat/base/error.h"

namespace cosplat {
namespace {

class LoneRank : public Ranks {
 public:
  size_t rank() const override { return 0; }
  size_t size() const override { return 1; }
  size_t local_rank() const override { return 0; }
  size_t local_size() const override { return 1; }
  void Exchange(const std::vector<View<const uint32_t>>&, std::vector<Message>& from) override {
    from.resize(1);
  }
  bool EndTogether() override { return true; }
  std::shared_ptr<Ranks> Part(size_t) override { return OneRank(); }
  uint64_t bytes_sent() const override { return 0; }
  double seconds() const override { return 0; }
};

}  // namespace

std::shared_ptr<Ranks> OneRank() { return std::make_shared<LoneRank>(); }

std::vector<Message> ExchangeWithAll(View<const uint32_t> message, Ranks& ranks) {
  std::vector<Message> from;
  ranks.Exchange(std::vector<View<const uint32_t>>(ranks.size(), message), from);
  return from;
}

uint64_t Sum(uint64_t number, Ranks& ranks) {
  const uint32_t words[2] = {uint32_t(number), uint32_t(number >> 32)};
  for (const Message& other : ExchangeWithAll({words, 2}, ranks))
    if (!other.empty()) number += other[0] + (uint64_t(other[1]) << 32);
  return number;
}

uint32_t Largest(uint32_t number, Ranks& ranks) {
  const uint32_t mine = number;
  for (const Message& other : ExchangeWithAll({&mine, 1}, ranks))
    if (!other.empty()) number = std::max(number, other[0]);
  return number;
}

uint32_t Smallest(uint32_t number, Ranks& ranks) { return ~Largest(~number, ranks); }

void CheckAlike(size_t gaussians, Ranks& ranks) {
  if (ranks.size() == 1) return;
  const uint32_t max = Largest(uint32_t(gaussians), ranks);
  const uint32_t fewest = Smallest(uint32_t(gaussians), ranks);
  if (max != fewest)
    throw Error("ranks",
                "have come to different numbers of Gaussians, " + std::to_string(fewest) + " to " +
                    std::to_string(max) + ": their machines and GPUs must be of one kind");
}

std::string TextOfRankZero(const std::string& text, Ranks& ranks) {
  // A character a word: it is short, and words are what messages are of.
  Message words;
  if (ranks.rank() == 0)
    for (const char c : text) words.push_back(uint8_t(c));
  const std::vector<Message> from = ExchangeWithAll(words, ranks);
  if (ranks.rank() == 0) return text;
  return {from[0].begin(), from[0].end()};
}

}  // namespace cosplat
