// Which Gaussians each tile draws, front to back: splat/render/cpu/tile_lists.h on the device.
//
// ProjectedSplat[] -> depth order, once per Gaussian -> (Gaussian, tile) instances in that order ->
// stable sort by tile -> beginnings of tiles, and of their buckets. Source: Faster-GS.
#pragma once

#include <cstdint>

#include "splat/device/cuda/stream.h"
#include "splat/device/sort.h"
#include "splat/render/kernels/projected_splat.h"
#include "splat/render/rasterizer.h"

namespace cosplat::cuda {

// A tile's instances are worked on in buckets of as many as a warp has lanes (Taming-3DGS).
constexpr uint32_t kBucket = 32;

// What kernels get. Instance k of the lists, by tile, then by depth, is of gaussian[k]; its
// gradient is kept at record[k]: contiguous per Gaussian. There is capacity for as many as were
// expected; where there are more (!Complete()) no tile has any.
struct TileListsView {
  int tiles_x = 0, tiles_y = 0;
  View<const uint32_t> gaussian, record;  // [capacity]
  View<const uint32_t> tile_begin;        // [tiles + 1]
  View<const uint64_t> bucket_begin;      // [tiles + 1]
  // Gaussians by depth, equal depths by index, undrawn ones last; where the records of each begin.
  View<const uint32_t> order;         // [count]
  View<const uint64_t> record_begin;  // [count + 1]

  __device__ bool Complete() const {
    return record_begin[record_begin.count - 1] <= gaussian.count;
  }
};

class TileLists {
 public:
  // Rebuilds for an image of this size. The host waits once, for the number of instances, unless it
  // was told what to expect. Throws Error when there are 2^31 or more, before storing any.
  void Build(View<const ProjectedSplat> splats,
             View<const float> radii,
             int width,
             int height,
             Stream& stream);

  // The next Build makes room for so many instances and waits for nothing. Where there are more, it
  // sets *exceeded, which is the device's, to 1 and leaves the lists empty.
  void Expect(size_t instances, uint32_t* exceeded);

  // On the device.
  const InstanceCounts* counts() const { return counts_.data(); }
  // What follows is sized by these, known without asking the device: entries of the lists, and
  // buckets, of which there are no more.
  size_t capacity() const { return capacity_; }
  size_t most_buckets() const { return capacity_ / kBucket + tiles(); }
  size_t tiles() const { return size_t(tiles_x_) * tiles_y_; }
  TileListsView view() const;
  size_t allocated() const { return gaussian_.capacity(); }  // entries that there is memory for
  // Bytes held; the second with scratch.
  size_t HeldForInstances() const;
  size_t HeldForGaussians() const;
  size_t HeldForTiles() const;

 private:
  void SortByDepth(View<const ProjectedSplat> splats, View<const float> radii, Stream& stream);
  void Count(View<const ProjectedSplat> splats, Stream& stream);
  void WaitForCounts(Stream& stream);
  void Emit(View<const ProjectedSplat> splats, Stream& stream);
  void FindTiles(Stream& stream);

  int tiles_x_ = 0, tiles_y_ = 0;
  size_t capacity_ = 0;
  uint32_t* exceeded_ = nullptr;   // of the next Build; null: it waits
  KeyedValues by_depth_;           // [count] values: indices of Gaussians, undrawn ones last
  Buffer<uint64_t> record_begin_;  // [count + 1]
  Buffer<InstanceCounts> counts_;  // [1]
  KeyedValues by_tile_;            // [capacity] values: records
  Buffer<uint32_t> of_record_;     // [capacity] a record's Gaussian
  Buffer<uint32_t> gaussian_;      // [capacity] in the order of the lists
  Buffer<uint32_t> tile_begin_;    // [tiles + 1]
  Buffer<uint64_t> bucket_begin_;  // [tiles + 1]
  std::unique_ptr<Readback<InstanceCounts>> readback_;
};

}  // namespace cosplat::cuda
