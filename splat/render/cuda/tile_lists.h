// Per-tile lists of Gaussians, front to back: splat/render/cpu/tile_lists.h on the device.
//
// ProjectedSplat[] -> depth order, once per Gaussian -> (Gaussian, tile) instances in that order ->
// stable sort by tile -> first instance and first bucket of each tile. Source: Faster-GS.
#pragma once

#include <cstdint>

#include "splat/device/cuda/stream.h"
#include "splat/device/sort.h"
#include "splat/render/kernels/projected_splat.h"
#include "splat/render/rasterizer.h"

namespace cosplat::cuda {

// A tile's instances are processed in buckets of one warp's width (Taming 3DGS).
constexpr uint32_t kBucket = 32;

// What kernels receive. Instance k of the lists, ordered by tile and then by depth, belongs to
// gaussian[k]; its gradient is stored at record[k], contiguous per Gaussian. The capacity is the
// expected number of instances; on overflow (!Complete()) all tiles are empty.
struct TileListsView {
  int tiles_x = 0, tiles_y = 0;
  View<const uint32_t> gaussian, record;  // [capacity]
  View<const uint32_t> tile_begin;        // [tiles + 1]
  View<const uint64_t> bucket_begin;      // [tiles + 1]
  // Gaussians by depth, ties by index, invisible ones last; and the first record of each.
  View<const uint32_t> order;         // [count]
  View<const uint64_t> record_begin;  // [count + 1]

  __device__ bool Complete() const {
    return record_begin[record_begin.count - 1] <= gaussian.count;
  }
};

// What sorts Gaussians by depth, written where they are projected; kNotDrawn sorts last. Depths are
// positive: their bits order like values.
constexpr uint32_t kNotDrawn = 0xffffffffu;
struct DepthKeys {
  View<uint32_t> keys, gaussians;  // [count]
  __device__ void Set(size_t i, float radius, const ProjectedSplat& splat) const {
    keys[i] = radius > 0 ? BitsOf(splat.depth) : kNotDrawn;
    gaussians[i] = uint32_t(i);
  }
};

class TileLists {
 public:
  // The first of two steps: where the projection has to write the keys of `count` Gaussians.
  DepthKeys Begin(size_t count, Stream& stream);
  // Rebuilds the lists for an image of this size. The host waits once, for the number of instances,
  // unless it was told what to expect. Throws Error if there are 2^31 or more, before storing any.
  void Build(View<const ProjectedSplat> splats, int width, int height, Stream& stream);

  // Makes the next Build allocate capacity for this many instances without waiting for their
  // number. On overflow, Build sets *exceeded, which is in device memory, to 1 and leaves the lists
  // empty.
  void Expect(size_t instances, uint32_t* exceeded);

  // In device memory.
  const InstanceCounts* counts() const { return counts_.data(); }
  // Capacity of the lists, and an upper bound on the number of buckets. Both are known without
  // querying the device; later stages size their buffers by them.
  size_t capacity() const { return capacity_; }
  size_t max_buckets() const { return capacity_ / kBucket + tiles(); }
  size_t tiles() const { return size_t(tiles_x_) * tiles_y_; }
  TileListsView view() const;
  size_t allocated() const { return gaussian_.capacity(); }  // entries that memory is allocated for
  // Bytes held, including scratch. GaussianBytes includes InstanceBytes.
  size_t InstanceBytes() const;
  size_t GaussianBytes() const;
  size_t TileBytes() const;

 private:
  void Count(View<const ProjectedSplat> splats, Stream& stream);
  void WaitForCounts(Stream& stream);
  void Emit(View<const ProjectedSplat> splats, uint32_t* exceeded, Stream& stream);
  void FindTiles(Stream& stream);

  int tiles_x_ = 0, tiles_y_ = 0;
  size_t capacity_ = 0;
  uint32_t* exceeded_ = nullptr;   // for the next Build; null: it waits for the number
  KeyedValues by_depth_;           // [count] values: indices of Gaussians, invisible ones last
  Buffer<uint64_t> record_begin_;  // [count + 1]
  Buffer<InstanceCounts> counts_;  // [1]
  KeyedValues by_tile_;            // [capacity] values: records
  Buffer<uint32_t> of_record_;     // [capacity] Gaussian of each record
  Buffer<uint32_t> gaussian_;      // [capacity] in list order
  Buffer<uint32_t> tile_begin_;    // [tiles + 1]
  Buffer<uint64_t> bucket_begin_;  // [tiles + 1]
  std::unique_ptr<Readback<uint64_t>> readback_;
};

}  // namespace cosplat::cuda
