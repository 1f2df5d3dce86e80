#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "splat/base/files.h"

namespace cosplat {
namespace {

constexpr std::array<uint32_t, 64> FirstPrimes() {
  std::array<uint32_t, 64> primes{};
  size_t count = 0;
  for (uint32_t n = 2; count < primes.size(); ++n) {
    bool prime = true;
    for (size_t i = 0; i < count; ++i) prime = prime && n % primes[i] != 0;
    if (prime) primes[count++] = n;
  }
  return primes;
}

// The standard defines its constants as the first 32 bits of the fractional parts of square roots
// (initial state) and cube roots (rounds) of the first primes. Found by bisection over integers:
// the largest r with r^k <= prime * 2^(32k); its low 32 bits are the fraction.
uint32_t RootFraction(uint32_t prime, int k) {
  using Wide = unsigned __int128;
  uint64_t low = 0, high = uint64_t(1) << 37;  // the roots are below 2^5
  const Wide target = Wide(prime) << (32 * k);
  while (high - low > 1) {
    const uint64_t mid = (low + high) / 2;
    const Wide power = k == 2 ? Wide(mid) * mid : Wide(mid) * mid * mid;  // below 2^111
    (power <= target ? low : high) = mid;
  }
  return uint32_t(low);
}

struct Constants {
  std::array<uint32_t, 64> round;
  std::array<uint32_t, 8> state;
  Constants() {
    constexpr std::array<uint32_t, 64> primes = FirstPrimes();
    for (int i = 0; i < 64; ++i) round[i] = RootFraction(primes[i], 3);
    for (int i = 0; i < 8; ++i) state[i] = RootFraction(primes[i], 2);
  }
};

class Hasher {
 public:
  Hasher() : state_(constants_.state) {}

  void Block(const uint8_t* p) {
    std::array<uint32_t, 64> w;
    for (int i = 0; i < 16; ++i, p += 4)
      w[i] = uint32_t(p[0]) << 24 | uint32_t(p[1]) << 16 | uint32_t(p[2]) << 8 | p[3];
    for (int i = 16; i < 64; ++i) {
      const uint32_t a = w[i - 15], b = w[i - 2];
      w[i] = w[i - 16] + w[i - 7] + (std::rotr(a, 7) ^ std::rotr(a, 18) ^ a >> 3) +
             (std::rotr(b, 17) ^ std::rotr(b, 19) ^ b >> 10);
    }
    std::array<uint32_t, 8> s = state_;
    for (int i = 0; i < 64; ++i) {
      const uint32_t sum1 = std::rotr(s[4], 6) ^ std::rotr(s[4], 11) ^ std::rotr(s[4], 25);
      const uint32_t choice = (s[4] & s[5]) ^ (~s[4] & s[6]);
      const uint32_t t1 = s[7] + sum1 + choice + constants_.round[i] + w[i];
      const uint32_t sum0 = std::rotr(s[0], 2) ^ std::rotr(s[0], 13) ^ std::rotr(s[0], 22);
      const uint32_t majority = (s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]);
      s = {t1 + sum0 + majority, s[0], s[1], s[2], s[3] + t1, s[4], s[5], s[6]};
    }
    for (int i = 0; i < 8; ++i) state_[i] += s[i];
  }

  std::string Hex() const {
    std::string text;
    for (uint32_t word : state_)
      for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[word >> shift & 15];
    return text;
  }

 private:
  Constants constants_;
  std::array<uint32_t, 8> state_;
};

}  // namespace

std::string Sha256(const void* bytes, size_t size) {
  const auto* p = static_cast<const uint8_t*>(bytes);
  Hasher hasher;
  size_t done = 0;
  for (; size - done >= 64; done += 64) hasher.Block(p + done);
  // Padding: a one bit, zeros, and the length in bits as 64-bit big-endian.
  std::array<uint8_t, 128> tail{};
  const size_t rest = size - done;
  if (rest > 0) std::memcpy(tail.data(), p + done, rest);
  tail[rest] = 0x80;
  const size_t tail_size = rest < 56 ? 64 : 128;
  for (int i = 0; i < 8; ++i) tail[tail_size - 1 - i] = uint8_t(uint64_t(size) * 8 >> 8 * i);
  for (size_t i = 0; i < tail_size; i += 64) hasher.Block(tail.data() + i);
  return hasher.Hex();
}

}  // namespace cosplat
