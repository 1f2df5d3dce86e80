#include "splat/render/cpu/tile_lists.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <string>
#include <utility>

#include "splat/base/error.h"
#include "splat/render/kernels/tile_range.h"

namespace cosplat {
namespace {

constexpr int kDigitBits = 11;  // of the radix sort: three passes
constexpr size_t kDigits = size_t(1) << kDigitBits;

constexpr size_t kPrefetch = 8;  // Gaussians ahead

// Few enough chunks that summing their counts is negligible.
constexpr size_t kGaussiansPerChunk = 8192, kMaxChunks = 32;
size_t ChunkCount(size_t n) {
  return std::min((n + kGaussiansPerChunk - 1) / kGaussiansPerChunk, kMaxChunks);
}

// Calls f(chunk, begin, end) in parallel.
template <class F>
void ForChunks(size_t n, const F& f) {
  const size_t chunks = ChunkCount(n);
  tbb::parallel_for(
      size_t(0), chunks, [&](size_t c) { f(c, n * c / chunks, n * (c + 1) / chunks); });
}

}  // namespace

// Collects the indices and depths of the visible splats, in index order. Also counts the tiles of
// whole bounding boxes, an upper bound on what will be stored, so that what does not fit is
// rejected before it fills memory.
void TileLists::CollectDrawn(View<const ProjectedSplat> splats, View<const float> radii) {
  const size_t n = splats.size();
  ForChunks(n, [&](size_t c, size_t begin, size_t end) {
    chunks_[c].drawn = 0;
    chunks_[c].covered = 0;
    for (size_t i = begin; i < end; ++i) {
      if (!(radii[i] > 0)) continue;
      const math::TileRange r = math::RangeOf(splats[i], tiles_x, tiles_y);
      ++chunks_[c].drawn;
      chunks_[c].covered += r.size();
    }
  });
  uint64_t covered = 0;
  uint32_t drawn = 0;
  for (size_t c = 0; c < ChunkCount(n); ++c) {
    covered += chunks_[c].covered;
    drawn += std::exchange(chunks_[c].drawn, drawn);
  }
  if (covered >= math::kInstanceLimit)
    throw Error("rasterizer", std::to_string(covered) + " splat-tile pairs; the limit is 2^31");
  order.Refill(drawn);
  keys_.Refill(drawn);
  ForChunks(n, [&](size_t c, size_t begin, size_t end) {
    uint32_t to = chunks_[c].drawn;
    for (size_t i = begin; i < end; ++i) {
      if (!(radii[i] > 0)) continue;
      order[to] = uint32_t(i);
      keys_[to++] = std::bit_cast<uint32_t>(splats[i].depth);  // positive: bits order like values
    }
  });
}

// One stable pass of a radix sort.
void TileLists::SortByDigit(int shift) {
  const size_t n = order.size();
  const auto digit = [shift](uint32_t key) { return (key >> shift) & (kDigits - 1); };
  ForChunks(n, [&](size_t c, size_t begin, size_t end) {
    std::vector<uint32_t>& count = chunks_[c].offset;
    count.assign(kDigits, 0);
    for (size_t i = begin; i < end; ++i) ++count[digit(keys_[i])];
  });
  uint32_t next = 0;
  for (size_t d = 0; d < kDigits; ++d)
    for (size_t c = 0; c < ChunkCount(n); ++c) next += std::exchange(chunks_[c].offset[d], next);
  ForChunks(n, [&](size_t c, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t to = chunks_[c].offset[digit(keys_[i])]++;
      keys_swap_[to] = keys_[i];
      order_swap_[to] = order[i];
    }
  });
  keys_.swap(keys_swap_);
  order.swap(order_swap_);
}

void TileLists::SortByDepth() {
  keys_swap_.Refill(keys_.size());
  order_swap_.Refill(order.size());
  for (int shift = 0; shift < 32; shift += kDigitBits) SortByDigit(shift);
}

// Lists the tiles of the Gaussians order[begin], ..., order[end - 1] and writes their tile counts
// to record_begin.
void TileLists::EmitChunk(View<const ProjectedSplat> splats,
                          size_t begin,
                          size_t end,
                          Chunk& chunk) {
  std::vector<uint32_t>& tiles = chunk.tiles;
  uint32_t count = 0;
  chunk.offset.assign(size_t(tiles_x) * tiles_y, 0);
  for (size_t k = begin; k < end; ++k) {
    if (k + kPrefetch < end) __builtin_prefetch(&splats[order[k + kPrefetch]]);
    const ProjectedSplat& s = splats[order[k]];
    const math::TileRange range = math::RangeOf(s, tiles_x, tiles_y);
    const size_t max = count + range.size();
    if (tiles.size() < max) {
      tiles.reserve(max + max / kHeadRoom);
      tiles.resize(tiles.capacity());
    }
    const uint32_t before = count;
    const bool test = NeedsTileTest(range);
    for (int ty = range.y0; ty < range.y1; ++ty)
      for (int tx = range.x0; tx < range.x1; ++tx) {
        // Branch-free: which tiles of a box are reached cannot be predicted.
        const uint32_t touched = !test || math::TouchesTile(s, tx, ty);
        const uint32_t tile = uint32_t(ty) * tiles_x + tx;
        tiles[count] = tile;
        count += touched;
        chunk.offset[tile] += touched;
      }
    record_begin[k] = count - before;
  }
  chunk.instances = count;
}

// Moves what EmitChunk wrote to its place in `entries` and turns the counts into offsets.
void TileLists::StoreChunk(size_t begin, size_t end, Chunk& chunk) {
  const uint32_t* tile = chunk.tiles.data();
  uint32_t record = chunk.first_record;
  for (size_t k = begin; k < end; ++k) {
    const uint32_t next = record + std::exchange(record_begin[k], record);
    for (; record < next; ++record) entries[chunk.offset[*tile++]++] = {order[k], record};
  }
}

void TileLists::Build(View<const ProjectedSplat> splats,
                      View<const float> radii,
                      int width,
                      int height) {
  tiles_x = math::TilesAcross(width);
  tiles_y = math::TilesAcross(height);
  const size_t tiles = size_t(tiles_x) * tiles_y;
  chunks_.resize(std::max(chunks_.size(), ChunkCount(splats.size())));
  CollectDrawn(splats, radii);
  SortByDepth();
  const size_t n = order.size();
  record_begin.Refill(n + 1);
  ForChunks(n,
            [&](size_t c, size_t begin, size_t end) { EmitChunk(splats, begin, end, chunks_[c]); });

  // Output positions of each chunk's instances of each tile: tile by tile, chunks in depth order.
  tile_begin.resize(tiles + 1);
  uint32_t next = 0;
  for (size_t t = 0; t < tiles; ++t) {
    tile_begin[t] = next;
    for (size_t c = 0; c < ChunkCount(n); ++c) next += std::exchange(chunks_[c].offset[t], next);
  }
  tile_begin[tiles] = next;

  uint32_t record = 0;
  for (size_t c = 0; c < ChunkCount(n); ++c) {
    chunks_[c].first_record = record;
    record += chunks_[c].instances;
  }
  record_begin[n] = record;
  entries.Refill(next);
  ForChunks(n, [&](size_t c, size_t begin, size_t end) { StoreChunk(begin, end, chunks_[c]); });
}

size_t TileLists::GaussianBytes() const {
  size_t bytes = AllocatedBytes(order, order_swap_, keys_, keys_swap_, record_begin, entries);
  for (const Chunk& chunk : chunks_) bytes += AllocatedBytes(chunk.tiles);
  return bytes;
}

size_t TileLists::TileBytes() const {
  size_t bytes = AllocatedBytes(tile_begin);
  for (const Chunk& chunk : chunks_) bytes += AllocatedBytes(chunk.offset);
  return bytes;
}

}  // namespace cosplat
