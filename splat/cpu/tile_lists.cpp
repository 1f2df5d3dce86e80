#include "splat/cpu/tile_lists.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>

#include "splat/base/error.h"
#include "splat/config.h"

namespace cosplat {
namespace {

// Fixed, so that the lists do not depend on the number of threads.
constexpr size_t kGaussiansPerChunk = 4096;
constexpr uint64_t kInstanceLimit = uint64_t(1) << 31;  // indices are 32 bits

struct TileRange {
  int x0, x1, y0, y1;  // half open
};

TileRange RangeOf(const ProjectedSplat& s, int tiles_x, int tiles_y) {
  // Clamped as floats: a huge splat's extent does not fit an int.
  const auto tile = [](float px, int limit) {
    return int(std::floor(std::clamp(px / kTileSize, 0.0f, float(limit))));
  };
  return {tile(s.x - s.half_x, tiles_x),
          std::min(tile(s.x + s.half_x, tiles_x) + 1, tiles_x),
          tile(s.y - s.half_y, tiles_y),
          std::min(tile(s.y + s.half_y, tiles_y) + 1, tiles_y)};
}

// Largest exponent of the splat along the segment from (dx0, dy) to (dx1, dy), relative to its
// centre; `flat` and `across` are the form's coefficients along and across the segment.
float LargestPowerOnEdge(float flat, float mixed, float across, float d0, float d1, float fixed) {
  // power = flat t^2 + mixed t fixed + across fixed^2, flat < 0.
  const float t = std::clamp(-mixed * fixed / (2 * flat), d0, d1);
  return (flat * t + mixed * fixed) * t + across * fixed * fixed;
}

// Whether any point of the tile reaches the splat's rejection level (Speedy-Splat's exact test).
bool Touches(const ProjectedSplat& s, int tile_x, int tile_y) {
  const float x0 = tile_x * kTileSize - s.x, x1 = x0 + kTileSize;
  const float y0 = tile_y * kTileSize - s.y, y1 = y0 + kTileSize;
  if (x0 <= 0 && x1 >= 0 && y0 <= 0 && y1 >= 0) return true;
  float best = -INFINITY;
  // Only the edges that face the centre can hold the largest value.
  if (x0 > 0 || x1 < 0)
    best = LargestPowerOnEdge(s.power_yy, s.power_xy, s.power_xx, y0, y1, x0 > 0 ? x0 : x1);
  if (y0 > 0 || y1 < 0)
    best = std::max(
        best, LargestPowerOnEdge(s.power_xx, s.power_xy, s.power_yy, x0, x1, y0 > 0 ? y0 : y1));
  return best >= s.reject_below;
}

// Counts whole rectangles, which is cheap and at least as many as will be stored: what does not fit
// is refused before it fills the memory.
void CheckInstanceCount(View<const uint32_t> order,
                        View<const ProjectedSplat> splats,
                        int tiles_x,
                        int tiles_y) {
  const uint64_t count = tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, order.size(), kGaussiansPerChunk),
      uint64_t(0),
      [&](const auto& range, uint64_t sum) {
        for (size_t k = range.begin(); k < range.end(); ++k) {
          const TileRange r = RangeOf(splats[order[k]], tiles_x, tiles_y);
          sum += uint64_t(r.x1 - r.x0) * uint64_t(r.y1 - r.y0);
        }
        return sum;
      },
      std::plus<uint64_t>());
  if (count >= kInstanceLimit)
    throw Error("", "rasterizer", std::to_string(count) + " splat-tile pairs; the limit is 2^31");
}

}  // namespace

void TileLists::SortByDepth(View<const ProjectedSplat> splats) {
  order.clear();
  keys_.clear();
  for (size_t i = 0; i < splats.size(); ++i) {
    if (!(splats[i].radius > 0)) continue;
    order.push_back(uint32_t(i));
    keys_.push_back(std::bit_cast<uint32_t>(splats[i].depth));  // positive: bits order as values
  }
  keys_swap_.resize(keys_.size());
  order_swap_.resize(order.size());
  constexpr int kBits = 11;
  for (int shift = 0; shift < 32; shift += kBits) {
    std::array<uint32_t, 1 << kBits> start{};
    const auto digit = [shift](uint32_t key) { return (key >> shift) & ((1u << kBits) - 1); };
    for (const uint32_t key : keys_) ++start[digit(key)];
    std::exclusive_scan(start.begin(), start.end(), start.begin(), 0u);
    for (size_t i = 0; i < keys_.size(); ++i) {
      const uint32_t to = start[digit(keys_[i])]++;
      keys_swap_[to] = keys_[i];
      order_swap_[to] = order[i];
    }
    keys_.swap(keys_swap_);
    order.swap(order_swap_);
  }
}

void TileLists::EmitChunk(View<const ProjectedSplat> splats,
                          size_t begin,
                          size_t end,
                          Chunk& chunk) const {
  chunk.instances.clear();
  chunk.per_gaussian.clear();
  chunk.tile_offset.assign(size_t(tiles_x) * tiles_y, 0);
  for (size_t k = begin; k < end; ++k) {
    const ProjectedSplat& s = splats[order[k]];
    const TileRange range = RangeOf(s, tiles_x, tiles_y);
    const size_t before = chunk.instances.size();
    for (int ty = range.y0; ty < range.y1; ++ty)
      for (int tx = range.x0; tx < range.x1; ++tx) {
        if (!Touches(s, tx, ty)) continue;
        const uint32_t tile = uint32_t(ty) * tiles_x + tx;
        chunk.instances.push_back({tile, order[k]});
        ++chunk.tile_offset[tile];
      }
    chunk.per_gaussian.push_back(uint32_t(chunk.instances.size() - before));
  }
}

void TileLists::Build(View<const ProjectedSplat> splats, int width, int height) {
  tiles_x = (width + kTileSize - 1) / kTileSize;
  tiles_y = (height + kTileSize - 1) / kTileSize;
  const size_t tiles = size_t(tiles_x) * tiles_y;
  SortByDepth(splats);
  CheckInstanceCount(order, splats, tiles_x, tiles_y);

  const size_t chunk_count = (order.size() + kGaussiansPerChunk - 1) / kGaussiansPerChunk;
  if (chunks_.size() < chunk_count) chunks_.resize(chunk_count);
  tbb::parallel_for(size_t(0), chunk_count, [&](size_t c) {
    const size_t begin = c * kGaussiansPerChunk;
    EmitChunk(splats, begin, std::min(begin + kGaussiansPerChunk, order.size()), chunks_[c]);
  });

  size_t total = 0;
  for (size_t c = 0; c < chunk_count; ++c) total += chunks_[c].instances.size();

  // Where each chunk's instances of each tile go: tile by tile, chunks in depth order.
  tile_begin.resize(tiles + 1);
  uint32_t next = 0;
  for (size_t t = 0; t < tiles; ++t) {
    tile_begin[t] = next;
    for (size_t c = 0; c < chunk_count; ++c) {
      const uint32_t count = chunks_[c].tile_offset[t];
      chunks_[c].tile_offset[t] = next;
      next += count;
    }
  }
  tile_begin[tiles] = next;

  record_begin.resize(order.size() + 1);
  uint32_t record = 0;
  for (size_t c = 0, k = 0; c < chunk_count; ++c)
    for (const uint32_t count : chunks_[c].per_gaussian) {
      record_begin[k++] = record;
      record += count;
    }
  record_begin[order.size()] = record;

  entries.resize(total);
  tbb::parallel_for(size_t(0), chunk_count, [&](size_t c) {
    uint32_t r = record_begin[c * kGaussiansPerChunk];
    for (const Instance& instance : chunks_[c].instances)
      entries[chunks_[c].tile_offset[instance.tile]++] = {instance.gaussian, r++};
  });
}

}  // namespace cosplat
