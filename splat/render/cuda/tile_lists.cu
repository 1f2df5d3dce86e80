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

// Depths are positive: their bits order like values.
struct DepthKey {
  View<const ProjectedSplat> splats;
  View<const float> radii;
  View<uint32_t> keys, gaussians;
  __device__ void operator()(size_t i) const {
    keys[i] = radii[i] > 0 ? BitsOf(splats[i].depth) : kNotDrawn;
    gaussians[i] = uint32_t(i);
  }
};

// Writes the number of instances and whether it exceeds the expected one.
struct TellCounts {
  View<const uint64_t> record_begin;
  size_t capacity;
  uint64_t* instances;
  uint32_t* exceeded;  // null: Expect was not called
  __device__ void operator()(size_t) const {
    *instances = record_begin[record_begin.count - 1];
    if (exceeded && *instances > capacity) *exceeded = 1;
  }
};

// Fills the unused entries so that they sort behind the last tile.
struct FillCapacity {
  View<const uint64_t> record_begin;
  uint32_t behind;
  View<uint32_t> tiles, records, of_record;
  __device__ void operator()(size_t r) const {
    const uint64_t instances = record_begin[record_begin.count - 1];
    if (r < instances && instances <= tiles.count) return;
    tiles[r] = behind;
    records[r] = uint32_t(r);
    of_record[r] = 0;
  }
};

struct GatherGaussians {
  View<const uint32_t> records, of_record;
  View<uint32_t> gaussian;
  __device__ void operator()(size_t k) const { gaussian[k] = of_record[records[k]]; }
};

struct CountBuckets {
  View<const uint32_t> tile_begin;
  View<uint64_t> buckets;
  __device__ void operator()(size_t t) const {
    const bool last = t + 1 == tile_begin.count;
    buckets[t] = last ? 0 : (tile_begin[t + 1] - tile_begin[t] + kBucket - 1) / kBucket;
  }
};

size_t BlocksOf(size_t n, unsigned threads) { return (n + threads - 1) / threads; }

}  // namespace

void TileLists::SortByDepth(View<const ProjectedSplat> splats,
                            View<const float> radii,
                            Stream& stream) {
  const size_t n = splats.count;
  by_depth_.Refill(n, stream);
  ForEachThread(n, stream, DepthKey{splats, radii, by_depth_.keys.view(), by_depth_.values.view()});
  stream.Sort(by_depth_, 32);
}

void TileLists::Count(View<const ProjectedSplat> splats, Stream& stream) {
  const size_t n = splats.count;
  record_begin_.Refill(n + 1, stream);
  counts_.Refill(1, stream);
  counts_.FillWithZeros(stream);
  const View<uint64_t> visible{&counts_.data()->visible, 1};
  ForBlocks(
      BlocksOf(n + 1, CountTiles::kThreads),
      stream,
      CountTiles{VisitorOf(splats, by_depth_, tiles_x_, tiles_y_), record_begin_.view(), visible});
  stream.ExclusiveSum(record_begin_);
  ForEachThread(
      1,
      stream,
      TellCounts{
          std::as_const(record_begin_).view(), capacity_, &counts_.data()->instances, exceeded_});
}

void TileLists::WaitForCounts(Stream& stream) {
  if (!readback_) readback_ = std::make_unique<Readback<InstanceCounts>>(stream);
  const uint64_t instances = readback_->Get(counts_.data(), stream).instances;
  if (instances >= math::kInstanceLimit)
    throw Error("rasterizer", std::to_string(instances) + " splat-tile pairs; the limit is 2^31");
  capacity_ = instances;
}

void TileLists::Emit(View<const ProjectedSplat> splats, Stream& stream) {
  by_tile_.Refill(capacity_, stream);
  of_record_.Refill(capacity_, stream);
  gaussian_.Refill(capacity_, stream);
  const auto record_begin = std::as_const(record_begin_).view();
  const auto tiles_of = by_tile_.keys.view(), records = by_tile_.values.view();
  ForBlocks(BlocksOf(splats.count, EmitInstances::kThreads),
            stream,
            EmitInstances{VisitorOf(splats, by_depth_, tiles_x_, tiles_y_),
                          record_begin,
                          uint32_t(tiles()),
                          tiles_of,
                          records,
                          of_record_.view()});
  ForEachThread(
      capacity_,
      stream,
      FillCapacity{record_begin, uint32_t(tiles()), tiles_of, records, of_record_.view()});
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
      tiles() + 1, stream, FindBegin{std::as_const(by_tile_.keys).view(), tile_begin_.view()});
  ForEachThread(
      tiles() + 1, stream, CountBuckets{std::as_const(tile_begin_).view(), bucket_begin_.view()});
  stream.ExclusiveSum(bucket_begin_);
}

void TileLists::Build(View<const ProjectedSplat> splats,
                      View<const float> radii,
                      int width,
                      int height,
                      Stream& stream) {
  tiles_x_ = math::TilesAcross(width);
  tiles_y_ = math::TilesAcross(height);
  SortByDepth(splats, radii, stream);
  Count(splats, stream);
  if (!std::exchange(exceeded_, nullptr)) WaitForCounts(stream);
  Emit(splats, stream);
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

size_t TileLists::HeldForInstances() const {
  return by_tile_.held() + HeldBy(of_record_, gaussian_);
}

size_t TileLists::HeldForGaussians() const {
  return by_depth_.held() + HeldForInstances() + HeldBy(record_begin_);
}

size_t TileLists::HeldForTiles() const { return HeldBy(tile_begin_, bucket_begin_); }

}  // namespace cosplat::cuda
