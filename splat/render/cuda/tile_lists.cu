#include <algorithm>
#include <bit>
#include <string>

#include "splat/device/buffer.h"
#include "splat/device/cuda/launch.cuh"
#include "splat/device/gather.h"
#include "splat/render/cuda/tile_lists.h"
#include "splat/render/cuda/tile_visit.cuh"

namespace cosplat::cuda {
namespace {

struct GatherGaussians {
  View<const uint32_t> records, of_record;
  View<uint32_t> gaussian;
  __device__ void operator()(size_t k) const { gaussian[k] = of_record[records[k]]; }
};

// Where each tile's instances begin, and how many buckets they fill.
struct FindTile {
  View<const uint32_t> tiles;  // of the instances, sorted
  View<uint32_t> tile_begin;   // [tiles + 1]
  View<uint64_t> buckets;      // likewise; the last is 0
  __device__ void operator()(size_t t) const {
    const uint32_t begin = LowerBound(tiles, t);
    const bool last = t + 1 == tile_begin.count;
    const uint32_t end = last ? begin : LowerBound(tiles, t + 1);
    tile_begin[t] = begin;
    buckets[t] = (end - begin + kBucket - 1) / kBucket;
  }
};

size_t BlocksOf(size_t n, unsigned threads) { return (n + threads - 1) / threads; }

}  // namespace

DepthKeys TileLists::Begin(size_t count, Stream& stream) {
  by_depth_.Refill(count, stream);
  return {by_depth_.keys.view(), by_depth_.values.view()};
}

void TileLists::Count(View<const ProjectedSplat> splats, Stream& stream) {
  const size_t n = splats.count;
  record_begin_.Refill(n + 1, stream);
  counts_.Refill(1, stream);
  ForBlocks(BlocksOf(n + 1, CountTiles::kThreads),
            stream,
            CountTiles{VisitorOf(splats, by_depth_, tiles_x_, tiles_y_),
                       record_begin_.view(),
                       &counts_.data()->visible});
  stream.ExclusiveSum(record_begin_);
}

void TileLists::WaitForCounts(Stream& stream) {
  if (!readback_) readback_ = std::make_unique<Readback<uint64_t>>(stream);
  const uint64_t instances =
      readback_->Get(record_begin_.data() + record_begin_.size() - 1, stream);
  if (instances >= math::kInstanceLimit)
    throw Error("rasterizer", std::to_string(instances) + " splat-tile pairs; the limit is 2^31");
  capacity_ = instances;
}

void TileLists::Emit(View<const ProjectedSplat> splats, uint32_t* exceeded, Stream& stream) {
  by_tile_.Refill(capacity_, stream);
  of_record_.Refill(capacity_, stream);
  gaussian_.Refill(capacity_, stream);
  ForBlocks(std::max<size_t>(1, BlocksOf(splats.count, EmitInstances::kThreads)),
            stream,
            EmitInstances{VisitorOf(splats, by_depth_, tiles_x_, tiles_y_),
                          std::as_const(record_begin_).view(),
                          uint32_t(tiles()),
                          by_tile_.keys.view(),
                          by_tile_.values.view(),
                          of_record_.view(),
                          &counts_.data()->instances,
                          exceeded});
  stream.Sort(by_tile_, std::bit_width(tiles()));
  ForEachThread(capacity_,
                stream,
                GatherGaussians{std::as_const(by_tile_.values).view(),
                                std::as_const(of_record_).view(),
                                gaussian_.view()});
}

void TileLists::FindTiles(Stream& stream) {
  tile_begin_.Refill(tiles() + 1, stream);
  bucket_begin_.Refill(tiles() + 1, stream);
  ForEachThread(
      tiles() + 1,
      stream,
      FindTile{std::as_const(by_tile_.keys).view(), tile_begin_.view(), bucket_begin_.view()});
  stream.ExclusiveSum(bucket_begin_);
}

void TileLists::Build(View<const ProjectedSplat> splats, int width, int height, Stream& stream) {
  tiles_x_ = math::TilesAcross(width);
  tiles_y_ = math::TilesAcross(height);
  stream.Sort(by_depth_, 32);
  Count(splats, stream);
  uint32_t* const exceeded = std::exchange(exceeded_, nullptr);
  if (!exceeded) WaitForCounts(stream);
  Emit(splats, exceeded, stream);
  FindTiles(stream);
}

void TileLists::Expect(size_t instances, uint32_t* exceeded) {
  capacity_ = std::min<size_t>(instances, math::kInstanceLimit - 1);
  exceeded_ = exceeded;
}

TileListsView TileLists::view() const {
  return {tiles_x_,
          tiles_y_,
          gaussian_.view(),
          by_tile_.values.view(),
          tile_begin_.view(),
          bucket_begin_.view(),
          by_depth_.values.view(),
          record_begin_.view()};
}

size_t TileLists::InstanceBytes() const {
  return by_tile_.allocated_bytes() + AllocatedBytes(of_record_, gaussian_);
}

size_t TileLists::GaussianBytes() const {
  return by_depth_.allocated_bytes() + InstanceBytes() + AllocatedBytes(record_begin_);
}

size_t TileLists::TileBytes() const { return AllocatedBytes(tile_begin_, bucket_begin_); }

}  // namespace cosplat::cuda
