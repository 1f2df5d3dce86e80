// How the blend loop lays out a tile: as blocks of 4x4 pixels, stored one after another, with a
// splat evaluated for all blocks at once.
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

// A tile's pixels are stored block by block: 4x4 px each, in as many packs as needed. A splat is
// blended only into the blocks that it reaches; for the small splats of a trained scene, this
// wastes fewer lanes than working on rows of the tile would.
constexpr int kBlockPixels = kBlockSize * kBlockSize;
constexpr int kBlocksPerRow = kTileSize / kBlockSize;
constexpr int kBlocks = kBlocksPerRow * kBlocksPerRow;
constexpr int kPixels = kTileSize * kTileSize;
constexpr int kPacksPerBlock = kBlockPixels / int(kLanes);
static_assert(kBlocks % kLanes == 0 && kBlockPixels % kLanes == 0);
using BlockMask = uint32_t;  // one bit per block
// What the forward pass notes of a splat for the backward pass: one bit per part of a block, a pack
// or 8 pixels if that is more.
constexpr int kPartPixels = std::max(8, int(kLanes));
constexpr int kPartsPerBlock = kBlockPixels / kPartPixels;
static_assert(kPixels / kPartPixels <= 32);
using PartMask = uint32_t;

HWY_INLINE int ColumnOf(int pixel) {
  return pixel / kBlockPixels % kBlocksPerRow * kBlockSize + pixel % kBlockSize;
}
HWY_INLINE int RowOf(int pixel) {
  return pixel / kBlockPixels / kBlocksPerRow * kBlockSize + pixel % kBlockPixels / kBlockSize;
}

HWY_INLINE PowerForm<Pack> FormOf(const ProjectedSplat& s) {
  return {Pack(s.power_xx), Pack(s.power_xy), Pack(s.power_yy)};
}

// Pixel positions in a tile: the first pixel of each block, and the offsets of a block's pixels
// from its first pixel.
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

// One splat evaluated for all blocks of a tile, one lane per block.
struct SplatOnTile {
  alignas(64) float dx[kBlocks], dy[kBlocks];  // from the splat's centre to (block_x, block_y)
  alignas(64) float power[kBlocks], d_power_x[kBlocks], d_power_y[kBlocks];  // PowerExpansion there
  Pack power_in_block[kPacksPerBlock];
  BlockMask reached;

  HWY_INLINE SplatOnTile(const ProjectedSplat& s, const TileGrid& grid) : form_(FormOf(s)) {
    const PowerRidges<Pack> ridges{Pack(s.x_per_y), Pack(s.y_per_x)};
    const Pack reject(s.reject_below), extent(float(kBlockSize - 1));
    reached = 0;
    for (int b = 0; b < kBlocks; b += int(kLanes)) {
      // Short packs lie within a row of blocks; most splats reach one or two of the four.
      if constexpr (kLanes <= kBlocksPerRow) {
        const float above = grid.block_y[b] - s.y;
        if (above > s.half_y || above + float(kBlockSize - 1) < -s.half_y) continue;
      }
      Expand(s, grid, b);
      const Pack left = LoadPack(dx + b), top = LoadPack(dy + b);
      const Pack largest = LargestPowerIn(form_, ridges, left, left + extent, top, top + extent);
      reached |= BlockMask(MaskBits(largest >= reject)) << b;
    }
    SetPowerInBlock(grid);
  }

  // Of the blocks that `parts` are of alone; `reached` is not set.
  HWY_INLINE SplatOnTile(const ProjectedSplat& s, const TileGrid& grid, PartMask parts)
      : form_(FormOf(s)) {
    constexpr int kParts = int(kLanes) * kPartsPerBlock;
    constexpr PartMask kOfPack = PartMask((uint64_t(1) << kParts) - 1);
    for (int b = 0; b < kBlocks; b += int(kLanes))
      if (parts >> (b * kPartsPerBlock) & kOfPack) Expand(s, grid, b);
    SetPowerInBlock(grid);
  }

  HWY_INLINE Pack PowerOf(int block, int pack, const TileGrid& grid) const {
    const PowerExpansion<Pack> at{
        Pack(power[block]), Pack(d_power_x[block]), Pack(d_power_y[block])};
    return PowerNear(at,
                     LoadPack(grid.in_block_x + pack * kLanes),
                     LoadPack(grid.in_block_y + pack * kLanes),
                     power_in_block[pack]);
  }

 private:
  // At as many blocks from the b-th on as a pack has lanes.
  HWY_INLINE void Expand(const ProjectedSplat& s, const TileGrid& grid, int b) {
    const Pack left = LoadPack(grid.block_x + b) - Pack(s.x);
    const Pack top = LoadPack(grid.block_y + b) - Pack(s.y);
    const PowerExpansion<Pack> at = ExpandAt(form_, left, top);
    StorePack(left, dx + b);
    StorePack(top, dy + b);
    StorePack(at.value, power + b);
    StorePack(at.d_x, d_power_x + b);
    StorePack(at.d_y, d_power_y + b);
  }
  HWY_INLINE void SetPowerInBlock(const TileGrid& grid) {
    for (int p = 0; p < kPacksPerBlock; ++p)
      power_in_block[p] = PowerAt(
          form_, LoadPack(grid.in_block_x + p * kLanes), LoadPack(grid.in_block_y + p * kLanes));
  }
  PowerForm<Pack> form_;
};

// Calls f(block, pack, first pixel of the pack) for each pack of the blocks in the mask.
template <class F>
HWY_INLINE void ForPacks(BlockMask blocks, const F& f) {
  for (; blocks != 0; blocks &= blocks - 1) {
    const int block = std::countr_zero(blocks);
    for (int pack = 0; pack < kPacksPerBlock; ++pack)
      f(block, pack, block * kBlockPixels + pack * int(kLanes));
  }
}

// Likewise for each pack of the parts in the mask.
template <class F>
HWY_INLINE void ForPacksOfParts(PartMask parts, const F& f) {
  for (; parts != 0; parts &= parts - 1) {
    const int part = std::countr_zero(parts);
    for (int at = part * kPartPixels; at < (part + 1) * kPartPixels; at += int(kLanes))
      f(at / kBlockPixels, at % kBlockPixels / int(kLanes), at);
  }
}

// Calls f(i, at, n) for each row of each block that lies on the image: its n pixels inside the
// image have tile indices i, i + 1, ... and image indices at, at + 1, ...
template <class F>
HWY_INLINE void ForRowsOnImage(const TileJob& job, const F& f) {
  for (int i = 0; i < kPixels; i += kBlockSize) {
    const int x = job.x0 + ColumnOf(i), y = job.y0 + RowOf(i);
    if (x >= job.width || y >= job.height) continue;
    const size_t at = size_t(y) * job.width + x;
    // With a constant count, a loop over it compiles to a single instruction.
    if (x + kBlockSize <= job.width)
      f(i, at, kBlockSize);
    else
      f(i, at, job.width - x);
  }
}

HWY_INLINE Vec3<Pack> ColorOfSplat(const ProjectedSplat& s) {
  return {Pack(s.r), Pack(s.g), Pack(s.b)};
}

// Returns the k-th splat, front to back. Splats are scattered in memory, so a later one is
// prefetched.
HWY_INLINE const ProjectedSplat& SplatAt(const TileJob& job, uint32_t k) {
  constexpr uint32_t kAhead = 8;
  __builtin_prefetch(&job.splats[job.entries[std::min(k + kAhead, job.entry_count - 1)].gaussian]);
  return job.splats[job.entries[k].gaussian];
}

// Sets the transmittance to 1 on the image and to 0 outside it, so that pixels outside accept no
// splats and do not keep the loop going.
HWY_INLINE void StartTransmittance(const TileJob& job, float* t) {
  std::fill(t, t + kPixels, 0.0f);
  ForRowsOnImage(job, [&](int i, size_t, int n) HWY_ATTR {
    for (int k = 0; k < n; ++k) t[i + k] = 1;
  });
}

// Blocks with a pixel that still accepts splats.
HWY_INLINE BlockMask OpenBlocks(const float* t) {
  BlockMask open = 0;
  for (int block = 0; block < kBlocks; ++block) {
    Pack max(0.0f);
    for (int i = 0; i < kBlockPixels; i += int(kLanes))
      max = Max(max, LoadPack(t + block * kBlockPixels + i));
    open |= BlockMask(AnyTrue(max >= Pack(kMinTransmittance))) << block;
  }
  return open;
}

COSPLAT_MATH_END
#endif
