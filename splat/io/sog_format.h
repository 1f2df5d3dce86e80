// What the writer and the reader of SOG share: names, the pixel of a splat, the domain of
// positions.
#pragma once

#include <cmath>
#include <cstddef>

namespace cosplat {

constexpr const char* kSogMeta = "meta.json";
constexpr const char* kSogOrigin = "offset";  // ours, which other programs pass over
constexpr int kSogVersion = 2;
constexpr int kSogCodebook = 256;        // entries of a codebook that a byte points into
constexpr int kSogPaletteRow = 64;       // colours in a row of the palette's image
constexpr int kSogMaxPalette = 1 << 16;  // which 16 bits point into
constexpr int kSogFirstMode = 252;       // alpha of a rotation whose first component is the largest
constexpr double kSogMaxPosition = 65535;  // 16 bits

inline double SogLog(double x) { return std::copysign(std::log1p(std::abs(x)), x); }
inline double SogUnlog(double x) { return std::copysign(std::expm1(std::abs(x)), x); }

}  // namespace cosplat
