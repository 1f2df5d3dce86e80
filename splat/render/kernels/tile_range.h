// Which tiles a projected splat can reach. Both back ends use these functions to list (splat, tile)
// pairs: counting and storing pairs must agree, and so must the CPU and the device.
#if defined(COSPLAT_SPLAT_KERNELS_TILE_RANGE_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_KERNELS_TILE_RANGE_H_
#undef COSPLAT_SPLAT_KERNELS_TILE_RANGE_H_
#else
#define COSPLAT_SPLAT_KERNELS_TILE_RANGE_H_
#endif

#include <cstdint>

#include "splat/math/blend.h"
#include "splat/render/kernels/projected_splat.h"

COSPLAT_MATH_BEGIN

// Limit on the (splat, tile) pairs of one view: indices have 32 bits.
constexpr uint64_t kInstanceLimit = uint64_t(1) << 31;

COSPLAT_HD int TilesAcross(int px) { return (px + kTileSize - 1) / kTileSize; }

struct TileRange {
  int x0, x1, y0, y1;  // half-open
  COSPLAT_HD int columns() const { return x1 > x0 ? x1 - x0 : 0; }
  COSPLAT_HD int rows() const { return y1 > y0 ? y1 - y0 : 0; }
  COSPLAT_HD uint64_t size() const { return uint64_t(columns()) * uint64_t(rows()); }
};

// The tile of a coordinate. Clamped as a float, since a huge splat's extent does not fit into an
// int; never negative, so that the conversion rounds down.
COSPLAT_HD int TileAt(float px, int limit) {
  return int(Clamp(px * (1.0f / kTileSize), 0.0f, float(limit)));
}

// Tiles with a pixel centre in the splat's bounding box; may be empty.
COSPLAT_HD TileRange RangeOf(const ProjectedSplat& s, int tiles_x, int tiles_y) {
  constexpr float kToLast = kTileSize - 0.5f;  // from a tile's edge to its last pixel centre
  return {TileAt(s.x - s.half_x + kTileSize - kToLast, tiles_x),
          TileAt(s.x + s.half_x + kToLast, tiles_x),
          TileAt(s.y - s.half_y + kTileSize - kToLast, tiles_y),
          TileAt(s.y + s.half_y + kToLast, tiles_y)};
}

// Whether the exponent can reach the splat's rejection threshold at a pixel centre of the rectangle
// of width x height pixels starting at (x0, y0). Splat must have ProjectedSplat's members.
template <class Splat>
COSPLAT_HD bool TouchesRectangle(const Splat& s, int x0, int y0, int width, int height) {
  const float x = x0 + 0.5f - s.x, y = y0 + 0.5f - s.y;
  const PowerForm<float> form{s.power_xx, s.power_xy, s.power_yy};
  return LargestPowerIn(form,
                        PowerRidges<float>{s.x_per_y, s.y_per_x},
                        x,
                        x + (width - 1),
                        y,
                        y + (height - 1)) >= s.reject_below;
}

COSPLAT_HD bool TouchesTile(const ProjectedSplat& s, int tile_x, int tile_y) {
  return TouchesRectangle(s, tile_x * kTileSize, tile_y * kTileSize, kTileSize, kTileSize);
}

// Whether the tiles of a range must be tested one by one: for a single tile it does not pay.
COSPLAT_HD bool NeedsTileTest(const TileRange& r) { return r.columns() > 1 || r.rows() > 1; }

COSPLAT_MATH_END
#endif
