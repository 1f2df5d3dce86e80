// Warp-wide walks over buckets. A bucket is 32 consecutive instances of a tile, one per lane; a
// walk visits all pixels of the tile that they can change.
//
// Pixels are pipelined through the lanes: in step s, lane l processes pixel s - l, whose state has
// already passed through the preceding lanes, which hold the splats in front of its own. Each lane
// therefore visits all pixels for its own splat and accumulates that splat's sum over the tile by
// itself, in one fixed order. Buckets start from the pixel states that the forward pass stored
// (PixelCheckpoint) and are independent of each other. Source: Mallick et al. 2024 (Taming 3DGS).
//
// Pixels that accept none of the splats are left out before: those that were opaque in front of
// the bucket, and the patches of 8 x 4 pixels (TilePixels) that none of the splats reaches.
#pragma once

#include "splat/render/cuda/blend.cuh"
#include "splat/render/cuda/tape.h"
#include "splat/render/kernels/tile_range.h"

namespace cosplat::cuda {

// Lists and images that every walk needs.
struct BucketLists {
  TileListsView lists;
  View<const ProjectedSplat> splats;
  View<const uint32_t> n_contrib;
  View<const PixelCheckpoint> checkpoints;
  View<const float> color;  // [3, height, width] the rendered image
  int width, height;
  __device__ size_t Plane() const { return size_t(width) * height; }
};

BucketLists BucketListsOf(const CudaTape& tape, const RenderedImage& image);

// A Walk defines
//   Pixel      what it needs of a pixel and splats do not change
//   State      what they change, and its transmittance; all zero for an opaque pixel
//   Sum        what is accumulated per splat
//   PixelOf    returns the Pixel at an index of the image
//   StartOf    returns its State before the bucket
//   Step       processes a pixel that accepts the splat
//   Finish     called once per instance; with a zero Sum if the instance was not processed
template <class Walk>
struct BucketKernel {
  static constexpr unsigned kThreads = 128;
  static constexpr unsigned kWarps = kThreads / kWarp;
  static constexpr int kOtherLanes = int(kWarp) - 1;
  BucketLists in;
  Walk walk;

  using Pixel = typename Walk::Pixel;
  using State = typename Walk::State;
  struct alignas(8) Center {
    float x, y;  // px
  };
  // A bucket's pixels, one array per use, so that lanes load whole vectors of neighbours.
  struct Pixels {
    Center center[kOtherLanes + kTilePixels + kOtherLanes];  // pixel p at kOtherLanes + p
    State start[kTilePixels + kOtherLanes];                  // the last ones are opaque
    Pixel pixel[kTilePixels];
  };
  struct Shared {
    Pixels of_warp[kWarps];
  };

  // Uses no block-wide barriers: warps are independent.
  __device__ void operator()() const {
    const uint64_t bucket = uint64_t(blockIdx.x) * kWarps + WarpInBlock();
    const int tiles = int(in.n_contrib.count);
    if (bucket >= in.lists.bucket_begin[tiles]) return;
    const int tile = TileOf(bucket, tiles);
    const uint32_t first = uint32_t(bucket - in.lists.bucket_begin[tile]) * kBucket;
    const uint32_t begin = in.lists.tile_begin[tile] + first, k = begin + Lane();
    const uint32_t splats = math::Min(in.lists.tile_begin[tile + 1] - begin, uint32_t(kBucket));
    const bool mine = Lane() < splats;
    const uint32_t gaussian = mine ? in.lists.gaussian[k] : 0;
    BlendSplat splat{};
    splat.reject_below = INFINITY;
    if (mine) splat = BlendSplat(in.splats[gaussian]);
    typename Walk::Sum sum{};
    if (first < in.n_contrib[tile]) {
      Pixels& pixels = SharedMemory<Shared>().of_warp[WarpInBlock()];
      const int count = LoadPixels(bucket, TilePixels(tile, in.lists.tiles_x), splat, pixels);
      PassPixels(pixels, count, int(splats), splat, sum);
    }
    if (mine) walk.Finish(k, gaussian, splat, sum);
  }

  // The last tile whose first bucket is at or before `bucket`.
  __device__ int TileOf(uint64_t bucket, int tiles) const {
    int low = 0, high = tiles;  // bucket_begin[low] <= bucket < bucket_begin[high]
    while (high - low > 1) {
      const int middle = low + (high - low) / 2;
      if (in.lists.bucket_begin[middle] <= bucket)
        low = middle;
      else
        high = middle;
    }
    return low;
  }

  // Returns the number of pixels that may accept one of the splats.
  __device__ int LoadPixels(uint64_t bucket,
                            const TilePixels& of_tile,
                            const BlendSplat& splat,
                            Pixels& pixels) const {
    int count = 0;
    for (int patch = 0; patch < kTilePixels; patch += int(kWarp)) {
      const bool reaches = math::TouchesRectangle(
          splat, of_tile.x(patch), of_tile.y(patch), kPatchWidth, kPatchHeight);
      if (!__any_sync(kAllLanes, reaches)) continue;
      const int p = patch + int(Lane()), x = of_tile.x(p), y = of_tile.y(p);
      const PixelCheckpoint before = in.checkpoints[bucket * kTilePixels + p];
      // Pixels outside the image are opaque.
      const bool open = before.x >= kMinTransmittance;
      const unsigned votes = __ballot_sync(kAllLanes, open);
      if (open) {
        const int to = count + __popc(votes & ((1u << Lane()) - 1));
        const size_t at = size_t(y) * in.width + x;
        pixels.center[kOtherLanes + to] = {x + 0.5f, y + 0.5f};
        pixels.pixel[to] = walk.PixelOf(in, at);
        pixels.start[to] = walk.StartOf(in, at, before, pixels.pixel[to]);
      }
      count += __popc(votes);
    }
    if (int(Lane()) < kOtherLanes) pixels.start[count + int(Lane())] = State{};
    __syncwarp();
    return count;
  }

  // A lane without a pixel, before the first or behind the last, has the state of an opaque one,
  // which accepts nothing, whatever its centre is.
  __device__ void PassPixels(const Pixels& pixels,
                             int count,
                             int splats,
                             const BlendSplat& splat,
                             typename Walk::Sum& sum) const {
    State state{};
    for (int step = 0; step < count + splats - 1; ++step) {
      state = state.FromLaneBefore();
      if (Lane() == 0) state = pixels.start[step];
      const int p = step - int(Lane());
      const Center center = pixels.center[kOtherLanes + p];
      const float dx = center.x - splat.x, dy = center.y - splat.y;
      const float power = PowerAt(splat.form(), dx, dy);
      if (math::Accepts(power, splat.reject_below, state.transmittance))
        walk.Step(pixels.pixel[p], splat, dx, dy, Falloff(power), state, sum);
    }
  }
};

template <class Walk>
void WalkBuckets(const CudaTape& tape,
                 const RenderedImage& image,
                 const Walk& walk,
                 Stream& stream) {
  using Kernel = BucketKernel<Walk>;
  if (tape.lists.capacity() == 0) return;
  const size_t blocks = (tape.lists.max_buckets() + Kernel::kWarps - 1) / Kernel::kWarps;
  ForBlocks(blocks, stream, Kernel{BucketListsOf(tape, image), walk});
}

}  // namespace cosplat::cuda
