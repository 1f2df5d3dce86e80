// Packets that are nearly good: what breaks parsers.
#pragma once

#include <string>
#include <vector>

#include "splat/base/rng.h"

namespace cosplat::test {

// One to four changes of `packet`: bits, bytes, cuts, repeats, splices of another seed's bytes, and
// words that parsers stumble over or that its format has.
inline std::string Mutated(std::string packet,
                           const std::vector<std::string>& seeds,
                           Rng& rng,
                           const std::vector<std::string>& words = {}) {
  static const std::vector<std::string> kTokens = {"#bundle",
                                                   std::string("\0\0\0\0", 4),
                                                   "\xff\xff\xff\xff",
                                                   "\x7f\xff\xff\xff",
                                                   ",b",
                                                   ",s",
                                                   "NaN",
                                                   "-Infinity",
                                                   "1e999",
                                                   "null",
                                                   "[",
                                                   "{",
                                                   "\"seq\":",
                                                   "-",
                                                   "\\u0000",
                                                   "\xc3\x28",
                                                   "\n"};
  for (uint64_t changes = 1 + rng.Below(4); changes > 0; --changes) {
    const size_t at = rng.Below(packet.size() + 1);
    const size_t count = rng.Below(packet.size() - at + 1);
    const std::string& other = seeds[rng.Below(seeds.size())];
    const size_t word = rng.Below(kTokens.size() + words.size());
    const std::string& token = word < kTokens.size() ? kTokens[word] : words[word - kTokens.size()];
    switch (rng.Below(7)) {
      case 0:
        if (at < packet.size()) packet[at] = char(packet[at] ^ (1 << rng.Below(8)));
        break;
      case 1:
        if (at < packet.size()) packet[at] = char(rng.Below(256));
        break;
      case 2:
        packet.erase(at, count);
        break;
      case 3:
        packet.resize(at);
        break;
      case 4:
        packet.insert(at, packet.substr(at, count));
        break;
      case 5:
        packet.replace(at, rng.Below(2) * token.size(), token);
        break;
      default:
        packet.replace(at, count, other.substr(rng.Below(other.size() + 1)));
    }
  }
  return packet;
}

}  // namespace cosplat::test
