// Definitions shared by the blending kernels.
#pragma once

#include "splat/config.h"
#include "splat/device/cuda/launch.cuh"
#include "splat/math/blend.h"
#include "splat/render/cuda/tile_lists.h"

namespace cosplat::cuda {

constexpr int kTilePixels = kTileSize * kTileSize;

// A tile's pixels are ordered warp by warp, each warp covering a patch 8 wide and 4 high: closer to
// a square than rows of the tile would be, so that fewer splats reach a warp.
constexpr int kPatchWidth = 8, kPatchHeight = 4;
constexpr int kPatchesAcross = kTileSize / kPatchWidth;
static_assert(kPatchWidth * kPatchHeight == kWarp && kTilePixels % kWarp == 0);

// Image coordinates of a tile's pixels: pixel p of the tile is at (x(p), y(p)).
struct TilePixels {
  int x0, y0;
  __device__ TilePixels(int tile, int tiles_x)
      : x0(tile % tiles_x * kTileSize), y0(tile / tiles_x * kTileSize) {}
  __device__ int x(int p) const {
    return x0 + p / int(kWarp) % kPatchesAcross * kPatchWidth + p % kPatchWidth;
  }
  __device__ int y(int p) const {
    return y0 + p / int(kWarp) / kPatchesAcross * kPatchHeight + p % int(kWarp) / kPatchWidth;
  }
};

// The part of a ProjectedSplat that blending needs: its first members, in their order, loaded by
// fours. Neighbours that 32 lanes load from shared memory are in different banks.
struct alignas(16) BlendSplat {
  float x, y, power_xx, power_xy;
  float power_yy, reject_below, x_per_y, y_per_x;
  float opacity, r, g, b;

  BlendSplat() = default;
  __device__ explicit BlendSplat(const ProjectedSplat& s)
      : x(s.x),
        y(s.y),
        power_xx(s.power_xx),
        power_xy(s.power_xy),
        power_yy(s.power_yy),
        reject_below(s.reject_below),
        x_per_y(s.x_per_y),
        y_per_x(s.y_per_x),
        opacity(s.opacity),
        r(s.r),
        g(s.g),
        b(s.b) {}
  __device__ math::PowerForm<float> form() const { return {power_xx, power_xy, power_yy}; }
  __device__ math::Vec3<float> color() const { return {r, g, b}; }
};
// e^power, the same in the forward and backward passes. Uses the hardware intrinsic, accurate to
// about 2 ulp in the range where alpha matters.
__device__ inline float Falloff(float power) { return __expf(power); }

}  // namespace cosplat::cuda
