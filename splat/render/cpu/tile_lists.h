// Per-tile lists of Gaussians, front to back.
// ProjectedSplat[] -> depth order -> (Gaussian, tile) instances in that order
// -> stable sort by tile.
// Sorting by depth once per Gaussian rather than once per instance follows Faster-GS.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/render/kernels/projected_splat.h"

namespace cosplat {

struct TileEntry {
  uint32_t gaussian;
  uint32_t record;  // where this instance's gradient is stored; contiguous per Gaussian
};

struct TileLists {
  int tiles_x = 0;
  int tiles_y = 0;
  Buffer<uint32_t> order;         // visible Gaussians by depth, ties by index
  Buffer<uint32_t> record_begin;  // [order.size() + 1] first record of order[k]
  Buffer<uint32_t> tile_begin;    // [tiles + 1]
  Buffer<TileEntry> entries;      // by tile, then by depth

  // Rebuilds the lists for an image of this size. Throws Error if the splats' bounding boxes cover
  // 2^31 tiles or more, before storing any.
  void Build(View<const ProjectedSplat> splats, View<const float> radii, int width, int height);

  // Bytes held, including scratch.
  size_t GaussianBytes() const;
  size_t TileBytes() const;

 private:
  // Scratch, reused between steps. A chunk is a range of Gaussians processed by one task; results
  // do not depend on where chunks begin.
  struct Chunk {
    std::vector<uint32_t> tiles;   // tiles of its instances; may have unused entries at the end
    std::vector<uint32_t> offset;  // per tile or digit: the count, later the first output position
    uint32_t drawn = 0;            // the count, later the first output position
    uint32_t instances = 0;
    uint32_t first_record = 0;
    uint64_t covered = 0;  // tiles covered by its splats' bounding boxes
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
