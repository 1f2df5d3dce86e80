// Lattice noise from integer hashes, without tables: bit-identical on all machines.
#pragma once

#include <cstdint>

#include "assets/head/vec.h"

namespace cosplat::procedural {

// A well-mixed 32-bit hash of three integers (xxHash's primes and finaliser).
inline uint32_t Hash(int x, int y, int z) {
  uint32_t h = uint32_t(x) * 0x85EBCA77u ^ uint32_t(y) * 0xC2B2AE3Du ^ uint32_t(z) * 0x27D4EB2Fu;
  h ^= h >> 15;
  h *= 0x85EBCA77u;
  h ^= h >> 13;
  h *= 0xC2B2AE3Du;
  return h ^ h >> 16;
}
inline float HashUnit(int x, int y, int z) { return float(Hash(x, y, z) >> 8) * 0x1p-24f; }

// Avoids a library call: the baseline instruction set has no rounding instruction.
inline int FloorOf(float x) {
  const int i = int(x);
  return i - (float(i) > x);
}

// Smooth value noise in [0, 1], mean 1/2; one lattice cell per unit.
inline float Noise(const Vec& p) {
  const int x = FloorOf(p.x), y = FloorOf(p.y), z = FloorOf(p.z);
  auto fade = [](float t) { return t * t * (3 - 2 * t); };
  const float u = fade(p.x - float(x)), v = fade(p.y - float(y)), w = fade(p.z - float(z));
  auto row = [&](int dy, int dz) {
    return Mix(HashUnit(x, y + dy, z + dz), HashUnit(x + 1, y + dy, z + dz), u);
  };
  return Mix(Mix(row(0, 0), row(1, 0), v), Mix(row(0, 1), row(1, 1), v), w);
}

// The same in the plane, repeating every `period` cells of x (0: never); `seed` selects a pattern.
inline float Noise2(float x, float y, int period, int seed) {
  const int ix = FloorOf(x), iy = FloorOf(y);
  auto fade = [](float t) { return t * t * (3 - 2 * t); };
  const float u = fade(x - float(ix)), v = fade(y - float(iy));
  auto wrap = [&](int i) { return period > 0 ? ((i % period) + period) % period : i; };
  const int x0 = wrap(ix), x1 = wrap(ix + 1);
  return Mix(Mix(HashUnit(x0, iy, seed), HashUnit(x1, iy, seed), u),
             Mix(HashUnit(x0, iy + 1, seed), HashUnit(x1, iy + 1, seed), u),
             v);
}

}  // namespace cosplat::procedural
