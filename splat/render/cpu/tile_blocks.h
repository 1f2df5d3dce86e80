// How the blend loop lays a tile out: blocks of 4x4 pixels, one after the other, and a splat over
// all of them at once.
#if defined(COSPLAT_SPLAT_CPU_TILE_BLOCKS_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_CPU_TILE_BLOCKS_H_
#undef COSPLAT_SPLAT_CPU_TILE_BLOCKS_H_
#else
#define COSPLAT_SPLAT_CPU_TILE_BLOCKS_H_
#endif

#include <algorithm>
#include <bit>

#include "splat/math/blend.h"
#include "splat/render/cpu/blend_tile.h"
#include "splat/render/cpu/pack.h"

COSPLAT_MATH_BEGIN

// A tile's pixels are kept block after block: 4x4 px each, in as many packs as they need. A splat
// works on the blocks that it reaches, which for the small splats of a trained scene wastes fewer
// lanes than rows of the tile do.
constexpr int kBlockPixels = kBlockSize * kBlockSize;
constexpr int kBlocksPerRow = kTileSize / kBlockSize;
constexpr int kBlocks = kBlocksPerRow * kBlocksPerRow;
constexpr int kPixels = kTileSize * kTileSize;
constexpr int kPacksPerBlock = kBlockPixels / int(kLanes);
static_assert(kBlocks % kLanes == 0 && kBlockPixels % kLanes == 0);
using BlockMask = uint32_t;  // a bit per block

HWY_INLINE int ColumnOf(int pixel) {
  return pixel / kBlockPixels % kBlocksPerRow * kBlockSize + pixel % kBlockSize;
}
HWY_INLINE int RowOf(int pixel) {
  return pixel / kBlockPixels / kBlocksPerRow * kBlockSize + pixel % kBlockPixels / kBlockSize;
}

HWY_INLINE PowerForm<Pack> FormOf(const ProjectedSplat& s) {
  return {Pack(s.power_xx), Pack(s.power_xy), Pack(s.power_yy)};
}

// Of a tile: where its blocks' first pixels are, and where a block's pixels are from its first.
struct TileGrid {
  alignas(64) float block_x[kBlocks], block_y[kBlocks];  // px, in the image, at pixel centres
  alignas(64) float in_block_x[kBlockPixels], in_block_y[kBlockPixels];  // px

  explicit TileGrid(const TileJob& job) {
    for (int b = 0; b < kBlocks; ++b) {
      block_x[b] = float(job.x0 + ColumnOf(b * kBlockPixels)) + 0.5f;
      block_y[b] = float(job.y0 + RowOf(b * kBlockPixels)) + 0.5f;
    }
    for (int i = 0; i < kBlockPixels; ++i) {
      in_block_x[i] = float(i % kBlockSize);
      in_block_y[i] = float(i / kBlockSize);
    }
  }
};

// One splat over all of a tile's blocks: a lane per block.
struct SplatOnTile {
  alignas(64) float dx[kBlocks], dy[kBlocks];  // from the centre to block_x, _y
  alignas(64) float power[kBlocks], d_power_x[kBlocks], d_power_y[kBlocks];  // PowerExpansion there
  Pack power_in_block[kPacksPerBlock];
  BlockMask reached;

  HWY_INLINE SplatOnTile(const ProjectedSplat& s, const TileGrid& grid) {
    const PowerForm<Pack> form = FormOf(s);
    const PowerRidges<Pack> ridges{Pack(s.x_per_y), Pack(s.y_per_x)};
    const Pack x(s.x), y(s.y), reject(s.reject_below), extent(float(kBlockSize - 1));
    reached = 0;
    for (int b = 0; b < kBlocks; b += int(kLanes)) {
      const Pack left = LoadPack(grid.block_x + b) - x, top = LoadPack(grid.block_y + b) - y;
      const PowerExpansion<Pack> at = ExpandAt(form, left, top);
      StorePack(left, dx + b);
      StorePack(top, dy + b);
      StorePack(at.value, power + b);
      StorePack(at.d_x, d_power_x + b);
      StorePack(at.d_y, d_power_y + b);
      const Pack largest = LargestPowerIn(form, ridges, left, left + extent, top, top + extent);
      reached |= BlockMask(MaskBits(largest >= reject)) << b;
    }
    for (int p = 0; p < kPacksPerBlock; ++p)
      power_in_block[p] = PowerAt(
          form, LoadPack(grid.in_block_x + p * kLanes), LoadPack(grid.in_block_y + p * kLanes));
  }

  HWY_INLINE Pack PowerOf(int block, int pack, const TileGrid& grid) const {
    const PowerExpansion<Pack> at{
        Pack(power[block]), Pack(d_power_x[block]), Pack(d_power_y[block])};
    return PowerNear(at,
                     LoadPack(grid.in_block_x + pack * kLanes),
                     LoadPack(grid.in_block_y + pack * kLanes),
                     power_in_block[pack]);
  }
};

// Calls f(block, pack, first pixel of the pack) for the blocks in the mask.
template <class F>
HWY_INLINE void ForPacks(BlockMask blocks, const F& f) {
  for (; blocks != 0; blocks &= blocks - 1) {
    const int block = std::countr_zero(blocks);
    for (int pack = 0; pack < kPacksPerBlock; ++pack)
      f(block, pack, block * kBlockPixels + pack * int(kLanes));
  }
}

// Calls f(i, at, n) for each row of each block: its n pixels on the image are the tile's i, i + 1,
// ... and the image's at, at + 1, ...
template <class F>
HWY_INLINE void ForRowsOnImage(const TileJob& job, const F& f) {
  for (int i = 0; i < kPixels; i += kBlockSize) {
    const int x = job.x0 + ColumnOf(i), y = job.y0 + RowOf(i);
    if (x >= job.width || y >= job.height) continue;
    const size_t at = size_t(y) * job.width + x;
    // A constant count makes a loop over it one instruction.
    if (x + kBlockSize <= job.width)
      f(i, at, kBlockSize);
    else
      f(i, at, job.width - x);
  }
}

HWY_INLINE Vec3<Pack> ColorOfSplat(const ProjectedSplat& s) {
  return {Pack(s.r), Pack(s.g), Pack(s.b)};
}

// The k-th splat, front to back. Splats lie scattered in memory: one that comes later is fetched
// now.
HWY_INLINE const ProjectedSplat& SplatAt(const TileJob& job, uint32_t k) {
  constexpr uint32_t kAhead = 8;
  __builtin_prefetch(&job.splats[job.entries[std::min(k + kAhead, job.entry_count - 1)].gaussian]);
  return job.splats[job.entries[k].gaussian];
}

// Transmittance 1 on the image, 0 beyond it: pixels outside take nothing and do not keep the loop
// going.
HWY_INLINE void StartTransmittance(const TileJob& job, float* t) {
  std::fill(t, t + kPixels, 0.0f);
  ForRowsOnImage(job, [&](int i, size_t, int n) HWY_ATTR {
    for (int k = 0; k < n; ++k) t[i + k] = 1;
  });
}

// Blocks with a pixel that still takes splats.
HWY_INLINE BlockMask OpenBlocks(const float* t) {
  BlockMask open = 0;
  for (int block = 0; block < kBlocks; ++block) {
    Pack most(0.0f);
    for (int i = 0; i < kBlockPixels; i += int(kLanes))
      most = Max(most, LoadPack(t + block * kBlockPixels + i));
    open |= BlockMask(AnyTrue(most >= Pack(kMinTransmittance))) << block;
  }
  return open;
}

COSPLAT_MATH_END
#endif
