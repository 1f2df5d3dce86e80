// Splats packed in PlayCanvas' compressed layout (splat/io/ply_layouts.h).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "splat/base/rng.h"

namespace cosplat::test {

constexpr size_t kChunk = 256;
constexpr float kSqrt2 = 1.41421356f;

struct Unpacked {
  std::array<float, 3> position, scale_log, color;
  std::array<float, 4> rotation;  // wxyz, norm 1
  float opacity;
};

inline std::vector<Unpacked> RandomSplats(size_t count) {
  Rng rng{7};
  std::vector<Unpacked> splats(count);
  for (Unpacked& s : splats) {
    float norm = 0;
    for (float& x : s.position) x = 3 * rng.Normal();
    for (float& x : s.scale_log) x = rng.Normal() - 4;
    for (float& x : s.color) x = 0.5f + rng.Normal();
    for (float& x : s.rotation) x = rng.Normal(), norm += x * x;
    for (float& x : s.rotation) x /= std::sqrt(norm);
    s.opacity = 0.5f + 0.45f * std::sin(rng.Normal());
  }
  return splats;
}

inline uint32_t Unorm(float share, int bits) {
  const float largest = float((1 << bits) - 1);
  return uint32_t(std::clamp(std::round(share * largest), 0.0f, largest));
}

struct Box {
  std::array<float, 3> low, high;
  float Share(int k, float x) const {
    return high[k] > low[k] ? (x - low[k]) / (high[k] - low[k]) : 0;
  }
};

template <class F>
Box ChunkBox(const std::vector<Unpacked>& splats, size_t begin, const F& values) {
  Box box{values(splats[begin]), values(splats[begin])};
  for (size_t i = begin; i < std::min(begin + kChunk, splats.size()); ++i)
    for (int k = 0; k < 3; ++k) {
      box.low[k] = std::min(box.low[k], values(splats[i])[k]);
      box.high[k] = std::max(box.high[k], values(splats[i])[k]);
    }
  return box;
}

inline uint32_t Pack111011(const Box& box, const std::array<float, 3>& x) {
  return Unorm(box.Share(0, x[0]), 11) << 21 | Unorm(box.Share(1, x[1]), 10) << 11 |
         Unorm(box.Share(2, x[2]), 11);
}

inline uint32_t PackRotation(const std::array<float, 4>& q) {
  uint32_t largest = 0;
  for (uint32_t k = 1; k < 4; ++k)
    if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
  uint32_t packed = largest;
  for (uint32_t k = 0; k < 4; ++k)
    if (k != largest)
      packed = packed << 10 | Unorm((q[largest] < 0 ? -q[k] : q[k]) / kSqrt2 + 0.5f, 10);
  return packed;
}

struct PackedLayout {
  bool color_bounds = true;
  int rest = 0;  // f_rest_* properties; values count up from 0 modulo 256
};

inline std::string PackedHeader(size_t count, const PackedLayout& o) {
  std::string h = "ply\nformat binary_little_endian 1.0\nelement chunk " +
                  std::to_string((count + kChunk - 1) / kChunk) + "\n";
  std::vector<std::array<const char*, 3>> kinds{{"x", "y", "z"}, {"scale_x", "scale_y", "scale_z"}};
  if (o.color_bounds) kinds.push_back({"r", "g", "b"});
  for (const auto& kind : kinds)
    for (const char* end : {"min_", "max_"})
      for (const char* axis : kind) h += std::string("property float ") + end + axis + "\n";
  h += "element vertex " + std::to_string(count) + "\n";
  for (const char* name : {"position", "rotation", "scale", "color"})
    h += std::string("property uint packed_") + name + "\n";
  if (o.rest > 0) h += "element sh " + std::to_string(count) + "\n";
  for (int k = 0; k < o.rest; ++k) h += "property uchar f_rest_" + std::to_string(k) + "\n";
  return h + "end_header\n";
}

inline std::string PackedFile(const std::vector<Unpacked>& splats, const PackedLayout& o) {
  const auto position = [](const Unpacked& s) { return s.position; };
  const auto scale = [](const Unpacked& s) { return s.scale_log; };
  const auto color = [](const Unpacked& s) { return s.color; };
  std::string chunks, vertices;
  const auto put = [](std::string& bytes, auto value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  for (size_t begin = 0; begin < splats.size(); begin += kChunk) {
    std::vector<Box> boxes{ChunkBox(splats, begin, position), ChunkBox(splats, begin, scale)};
    if (o.color_bounds) boxes.push_back(ChunkBox(splats, begin, color));
    for (const Box& box : boxes) put(chunks, box.low), put(chunks, box.high);
    const Box colors = o.color_bounds ? boxes[2] : Box{{0, 0, 0}, {1, 1, 1}};
    for (size_t i = begin; i < std::min(begin + kChunk, splats.size()); ++i) {
      const Unpacked& s = splats[i];
      put(vertices, Pack111011(boxes[0], s.position));
      put(vertices, PackRotation(s.rotation));
      put(vertices, Pack111011(boxes[1], s.scale_log));
      uint32_t rgba = 0;
      for (int k = 0; k < 3; ++k) rgba = rgba << 8 | Unorm(colors.Share(k, s.color[k]), 8);
      put(vertices, rgba << 8 | Unorm(s.opacity, 8));
    }
  }
  std::string rest;
  for (size_t k = 0; k < splats.size() * size_t(o.rest); ++k) put(rest, uint8_t(k));
  return PackedHeader(splats.size(), o) + chunks + vertices + rest;
}

}  // namespace cosplat::test
