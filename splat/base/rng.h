// A small random generator whose state is one number, so that a checkpoint holds it, and whose bits
// do not depend on the standard library. Source: SplitMix64 (Steele, Lea & Flood 2014).
#pragma once

#include <cmath>
#include <cstdint>

namespace cosplat {

struct Rng {
  uint64_t state = 0;

  uint64_t Next() {
    state += 0x9e3779b97f4a7c15ull;
    uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  // [0, 1), 24 bits.
  float Uniform() { return float(Next() >> 40) * 0x1p-24f; }
  // [0, n), n >= 1.
  uint64_t Below(uint64_t n) { return Next() % n; }
  // Standard normal (Box & Muller 1958).
  float Normal() {
    const float radius = std::sqrt(-2 * std::log(1 - Uniform()));
    return radius * std::cos(6.28318530718f * Uniform());
  }
};

}  // namespace cosplat
