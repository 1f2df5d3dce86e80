// A small random number generator with a single integer as state, which a checkpoint can store, and
// with output that does not depend on the standard library. Usable in device code. Source:
// SplitMix64 (Steele, Lea & Flood 2014).
#pragma once

#include <cmath>
#include <cstdint>

#include "splat/math/namespace.h"

namespace cosplat {

struct Rng {
  uint64_t state = 0;

  static constexpr uint64_t kStep = 0x9e3779b97f4a7c15ull;

  COSPLAT_HD uint64_t Next() {
    state += kStep;
    uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  // [0, 1), 24 bits.
  COSPLAT_HD float Uniform() { return float(Next() >> 40) * 0x1p-24f; }
  // [0, n), n >= 1.
  COSPLAT_HD uint64_t Below(uint64_t n) { return Next() % n; }
  // Standard normal (Box & Muller 1958).
  COSPLAT_HD float Normal() {
    const float radius = std::sqrt(-2 * std::log(1 - Uniform()));
    return radius * std::cos(6.28318530718f * Uniform());
  }
  // The generator after `draws` calls of Next(), so that draws can be made in parallel.
  COSPLAT_HD Rng After(uint64_t draws) const { return {state + draws * kStep}; }
};

}  // namespace cosplat
