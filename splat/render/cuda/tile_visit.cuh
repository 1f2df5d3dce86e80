// Which tiles each splat touches: counted first, then stored (splat/render/cuda/tile_lists.cu).
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/device/buffer.h"
#include "splat/device/cuda/launch.cuh"
#include "splat/render/cuda/tile_lists.h"
#include "splat/render/kernels/projected_splat.h"
#include "splat/render/kernels/tile_range.h"

namespace cosplat::cuda {

// Splats over more tiles than this are processed by a whole warp.
constexpr uint32_t kFewTiles = 4;

// Visits the tiles of every Gaussian, in depth order and row by row; a warp processes 32
// consecutive Gaussians. Calls visit(k, tile, n) for the n-th tile that the k-th Gaussian in depth
// order touches. Returns the number of tiles that the lane's own Gaussian touches. Counting and
// storing must agree, so both use this.
struct TileVisitor {
  View<const ProjectedSplat> splats;
  View<const uint32_t> keys, gaussians;
  int tiles_x, tiles_y;

  __device__ bool IsDrawn(size_t k) const { return k < keys.count && keys[k] != kNotDrawn; }
  template <class Visit>
  __device__ uint32_t Run(size_t k, const Visit& visit) const {
    const bool drawn = IsDrawn(k);
    const uint32_t i = drawn ? gaussians[k] : 0;
    math::TileRange range{0, 0, 0, 0};
    if (drawn) range = math::RangeOf(splats[i], tiles_x, tiles_y);
    const bool many = uint32_t(range.size()) > kFewTiles;  // an image has fewer than 2^32 tiles
    uint32_t touched = 0;
    if (!many) touched = Alone(k, i, range, visit);
    for (unsigned left = __ballot_sync(kAllLanes, many); left != 0; left &= left - 1) {
      const int owner = __ffs(left) - 1;
      const uint32_t n = Together(k - Lane() + owner, __shfl_sync(kAllLanes, i, owner), visit);
      if (int(Lane()) == owner) touched = n;
    }
    return touched;
  }

 private:
  template <class Visit>
  __device__ uint32_t
  Alone(size_t k, uint32_t i, const math::TileRange& range, const Visit& visit) const {
    uint32_t touched = 0;
    const bool test = NeedsTileTest(range);
    for (int y = range.y0; y < range.y1; ++y)
      for (int x = range.x0; x < range.x1; ++x)
        if (!test || math::TouchesTile(splats[i], x, y))
          visit(k, uint32_t(y) * tiles_x + x, touched++);
    return touched;
  }

  // Called by all lanes, each of which tests one tile at a time.
  template <class Visit>
  __device__ uint32_t Together(size_t k, uint32_t i, const Visit& visit) const {
    const ProjectedSplat& splat = splats[i];
    const math::TileRange range = math::RangeOf(splat, tiles_x, tiles_y);
    const uint32_t size = uint32_t(range.size()), columns = uint32_t(range.columns());
    uint32_t touched = 0;
    for (uint32_t first = 0; first < size; first += kWarp) {
      const uint32_t at = first + Lane(), row = at / columns;
      const int x = range.x0 + int(at - row * columns), y = range.y0 + int(row);
      const bool touches = at < size && math::TouchesTile(splat, x, y);
      const unsigned votes = __ballot_sync(kAllLanes, touches);
      const unsigned before = votes & ((1u << Lane()) - 1);
      if (touches) visit(k, uint32_t(y) * tiles_x + x, touched + __popc(before));
      touched += __popc(votes);
    }
    return touched;
  }
};

inline TileVisitor VisitorOf(View<const ProjectedSplat> splats,
                             const KeyedValues& by_depth,
                             int tiles_x,
                             int tiles_y) {
  return {splats, by_depth.keys.view(), by_depth.values.view(), tiles_x, tiles_y};
}

// Tiles of each Gaussian, and the number of visible ones. Needs a thread more than there are
// Gaussians.
struct CountTiles {
  static constexpr unsigned kThreads = 256;
  TileVisitor visitor;
  View<uint64_t> counts;  // [keys + 1]; the last is 0
  uint64_t* visible;
  __device__ void operator()() const {
    const size_t k = size_t(blockIdx.x) * kThreads + threadIdx.x;
    const uint32_t n = visitor.Run(k, [](size_t, uint32_t, uint32_t) {});
    if (k < counts.count) counts[k] = n;
    // Invisible ones are last: just one index is behind a visible one, or 0, and not visible
    // itself.
    if (k < counts.count && !visitor.IsDrawn(k) && (k == 0 || visitor.IsDrawn(k - 1))) *visible = k;
  }
};

// Stores the instances of every Gaussian behind those of the Gaussians before it, fills the rest of
// the capacity so that it sorts behind the last tile, and reports their number. CountTiles and this
// decide in two compilations whether a splat touches a tile, and the compiler may round them
// differently: no Gaussian gets more instances than were counted, and those that it lacks belong to
// no tile.
struct EmitInstances {
  static constexpr unsigned kThreads = 256;
  TileVisitor visitor;
  View<const uint64_t> record_begin;
  uint32_t behind;                           // sorts behind the last tile
  View<uint32_t> tiles, records, of_record;  // [capacity]
  uint64_t* instances;
  uint32_t* exceeded;  // set to 1 if they exceed the capacity, and all of it belongs to no tile

  __device__ void operator()() const {
    const uint64_t total = record_begin[record_begin.count - 1];
    const bool fits = total <= tiles.count;
    const size_t k = size_t(blockIdx.x) * kThreads + threadIdx.x;
    if (k == 0) {
      *instances = total;
      if (!fits) *exceeded = 1;
    }
    const size_t threads = size_t(gridDim.x) * kThreads;
    for (uint64_t r = (fits ? total : 0) + k; r < tiles.count; r += threads) Store(r, behind, 0);
    if (fits) EmitOf(k);
  }

 private:
  __device__ void EmitOf(size_t k) const {
    const EmitInstances& self = *this;
    const uint32_t touched = visitor.Run(k, [&self](size_t owner, uint32_t tile, uint32_t n) {
      const uint64_t r = self.record_begin[owner] + n;
      if (r < self.record_begin[owner + 1]) self.Store(r, tile, self.visitor.gaussians[owner]);
    });
    if (k >= visitor.keys.count) return;
    for (uint64_t r = record_begin[k] + touched; r < record_begin[k + 1]; ++r)
      Store(r, behind, visitor.gaussians[k]);
  }
  __device__ void Store(uint64_t r, uint32_t tile, uint32_t gaussian) const {
    tiles[r] = tile;
    records[r] = uint32_t(r);
    of_record[r] = gaussian;
  }
};

}  // namespace cosplat::cuda
