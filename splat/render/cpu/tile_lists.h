// Which Gaussians each tile draws, front to back.
// ProjectedSplat[] -> depth order -> (Gaussian, tile) instances in that order -> stable sort by
// tile. Sorting by depth once per Gaussian rather than per instance: Faster-GS.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/render/kernels/projected_splat.h"

namespace cosplat {

struct TileEntry {
  uint32_t gaussian;
  uint32_t record;  // where this instance's gradient is kept: contiguous per Gaussian
};

struct TileLists {
  int tiles_x = 0;
  int tiles_y = 0;
  Buffer<uint32_t> order;         // drawn Gaussians by depth; equal depths by index
  Buffer<uint32_t> record_begin;  // [order.size() + 1] instances of order[k], in `record` numbering
  Buffer<uint32_t> tile_begin;    // [tiles + 1]
  Buffer<TileEntry> entries;      // by tile, then by depth

  // Rebuilds for an image of this size. Throws Error when the splats' boxes cover 2^31 tiles or
  // more, before storing any.
  void Build(View<const ProjectedSplat> splats, View<const float> radii, int width, int height);

  // Bytes held, scratch included.
  size_t HeldForGaussians() const;
  size_t HeldForTiles() const;

 private:
  // Scratch, kept between steps. A chunk is a range of Gaussians that one task works on; results do
  // not depend on where chunks begin.
  struct Chunk {
    std::vector<uint32_t> tiles;   // of its instances, then room
    std::vector<uint32_t> offset;  // per tile or digit: counts, then where the first goes
    uint32_t drawn = 0;            // counts, then where the first goes
    uint32_t instances = 0;
    uint32_t first_record = 0;
    uint64_t covered = 0;  // tiles of its splats' boxes
  };
  std::vector<Chunk> chunks_;
  Buffer<uint32_t> keys_, keys_swap_, order_swap_;

  void CollectDrawn(View<const ProjectedSplat> splats, View<const float> radii);
  void SortByDepth();
  void SortByDigit(int shift);
  void EmitChunk(View<const ProjectedSplat> splats, size_t begin, size_t end, Chunk& chunk);
  void StoreChunk(size_t begin, size_t end, Chunk& chunk);
};

}  // namespace cosplat
