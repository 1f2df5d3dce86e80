// Which Gaussians each tile draws, front to back: splat/cpu/tile_lists.h on the device.
//
// ProjectedSplat[] -> depth order, once per Gaussian -> (Gaussian, tile) instances in that order ->
// stable sort by tile -> beginnings of tiles, and of their buckets. Source: Faster-GS.
#pragma once

#include <cstdint>

#include "splat/cuda/sort.h"
#include "splat/kernels/projected_splat.h"

namespace cosplat::cuda {

// A tile's instances are worked on in buckets of as many as a warp has lanes (Taming-3DGS).
constexpr uint32_t kBucket = 32;

// What kernels get. Instance k of the lists, by tile, then by depth, is of gaussian[k]; its
// gradient is kept at record[k]: contiguous per Gaussian.
struct TileListsView {
  int tiles_x = 0, tiles_y = 0;
  DeviceView<const uint32_t> gaussian, record;  // [instances]
  DeviceView<const uint32_t> tile_begin;        // [tiles + 1]
  DeviceView<const uint64_t> bucket_begin;      // [tiles + 1]
  // Drawn Gaussians by depth, equal depths by index; and where the records of each begin.
  DeviceView<const uint32_t> order;         // [visible]
  DeviceView<const uint64_t> record_begin;  // [visible + 1]
};

class TileLists {
 public:
  // Rebuilds for an image of this size. The host waits once, for the number of instances. Throws
  // Error when there are 2^31 or more, before storing any.
  void Build(DeviceView<const ProjectedSplat> splats,
             DeviceView<const float> radii,
             int width,
             int height,
             cudaStream_t stream);

  size_t visible() const { return visible_; }
  size_t instances() const { return instances_; }
  size_t tiles() const { return size_t(tiles_x_) * tiles_y_; }
  // At least as many as there are: known without asking the device.
  size_t most_buckets() const { return instances_ / kBucket + tiles(); }
  TileListsView view() const;
  // Bytes held, scratch included.
  size_t HeldForGaussians() const;
  size_t HeldForTiles() const;

 private:
  struct Counts {
    uint64_t instances, visible;
  };

  void SortByDepth(DeviceView<const ProjectedSplat> splats,
                   DeviceView<const float> radii,
                   cudaStream_t stream);
  void Count(DeviceView<const ProjectedSplat> splats, cudaStream_t stream);
  void Emit(DeviceView<const ProjectedSplat> splats, cudaStream_t stream);
  void FindTiles(cudaStream_t stream);

  int tiles_x_ = 0, tiles_y_ = 0;
  size_t visible_ = 0, instances_ = 0;
  KeyedValues by_depth_;                 // [count] values: indices of Gaussians, undrawn ones last
  DeviceBuffer<uint64_t> record_begin_;  // [count + 1]
  DeviceBuffer<Counts> counts_;          // [1]
  KeyedValues by_tile_;                  // [instances] values: records
  DeviceBuffer<uint32_t> of_record_;     // [instances] a record's Gaussian
  DeviceBuffer<uint32_t> gaussian_;      // [instances] in the order of the lists
  DeviceBuffer<uint32_t> tile_begin_;    // [tiles + 1]
  DeviceBuffer<uint64_t> bucket_begin_;  // [tiles + 1]
  Sorter sorter_;
  Readback<Counts> readback_;
};

}  // namespace cosplat::cuda
