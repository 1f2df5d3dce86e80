#include "splat/cpu/blend_tile.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cpu/blend_tile.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/cpu/pack.h"
#include "splat/math/blend.h"

COSPLAT_MATH_BEGIN

constexpr int kPixels = kTileSize * kTileSize;
constexpr int kPacksPerRow = kTileSize / int(kLanes);
// Whether every pixel is opaque is looked at after this many splats.
constexpr uint32_t kStopInterval = 16;

// Rows [begin, end) and packs [pack_begin, pack_end) of the tile that the splat's box covers.
struct TileSpan {
  int row_begin, row_end, pack_begin, pack_end;
};
HWY_INLINE TileSpan SpanOf(const ProjectedSplat& s, const TileJob& job) {
  // Clamped before conversion: a huge splat's extent does not fit an int.
  const float left = s.x - job.x0 - 0.5f, top = s.y - job.y0 - 0.5f;
  const auto clamp = [](float v) HWY_ATTR { return v < 0 ? 0.0f : (v > 16.0f ? 16.0f : v); };
  static_assert(kTileSize == 16);
  const int col_begin = int(clamp(left - s.half_x));
  const int col_end = int(clamp(left + s.half_x + 1.0f) + 0.999f);
  const int row_begin = int(clamp(top - s.half_y));
  const int row_end = int(clamp(top + s.half_y + 1.0f) + 0.999f);
  const int lanes = int(kLanes);
  return {row_begin, row_end, col_begin / lanes, (col_end + lanes - 1) / lanes};
}

HWY_INLINE PowerForm<Pack> FormOf(const ProjectedSplat& s) {
  return {Pack(s.power_xx), Pack(s.power_xy), Pack(s.power_yy)};
}
HWY_INLINE Vec3<Pack> ColorOfSplat(const ProjectedSplat& s) {
  return {Pack(s.r), Pack(s.g), Pack(s.b)};
}

struct alignas(64) TilePixels {
  float t[kPixels], r[kPixels], g[kPixels], b[kPixels];
};

// Transmittance 1 on the image, 0 beyond it: pixels outside take nothing and do not keep the loop
// going.
HWY_INLINE void StartTransmittance(const TileJob& job, float* t) {
  for (int y = 0; y < kTileSize; ++y)
    for (int x = 0; x < kTileSize; ++x)
      t[y * kTileSize + x] = job.y0 + y < job.height && job.x0 + x < job.width ? 1.0f : 0.0f;
}

HWY_INLINE bool AllOpaque(const float* t) {
  Pack most(0.0f);
  for (int i = 0; i < kPixels; i += int(kLanes)) most = Max(most, LoadPack(t + i));
  return !AnyTrue(most >= Pack(kMinTransmittance));
}

void BlendSplat(const ProjectedSplat& s, const TileJob& job, TilePixels& px) {
  const TileSpan span = SpanOf(s, job);
  const PowerForm<Pack> form = FormOf(s);
  const Vec3<Pack> color = ColorOfSplat(s);
  const Pack opacity(s.opacity), reject(s.reject_below);
  for (int j = span.pack_begin; j < span.pack_end; ++j) {
    const Pack dx = Ramp(float(job.x0 + j * int(kLanes)) + 0.5f - s.x);
    for (int y = span.row_begin; y < span.row_end; ++y) {
      const PowerRow<Pack> row = AtRow(form, Pack(float(job.y0 + y) + 0.5f - s.y));
      const Pack power = PowerAt(row, dx);
      const int at = y * kTileSize + j * int(kLanes);
      BlendState<Pack> state{LoadPack(px.t + at), {}};
      const PackMask accept = Accepts(power, reject, state.transmittance);
      if (!AnyTrue(accept)) continue;
      state.color = {LoadPack(px.r + at), LoadPack(px.g + at), LoadPack(px.b + at)};
      BlendBehind(accept, AlphaOf(opacity, Exp(power)), color, state);
      StorePack(state.transmittance, px.t + at);
      StorePack(state.color.x, px.r + at);
      StorePack(state.color.y, px.g + at);
      StorePack(state.color.z, px.b + at);
    }
  }
}

uint32_t ForwardTile(const TileJob& job) {
  TilePixels px;
  StartTransmittance(job, px.t);
  for (int i = 0; i < kPixels; ++i) px.r[i] = px.g[i] = px.b[i] = 0;
  uint32_t k = 0;
  while (k < job.entry_count) {
    const uint32_t stop = std::min(k + kStopInterval, job.entry_count);
    for (; k < stop; ++k) BlendSplat(job.splats[job.entries[k].gaussian], job, px);
    if (AllOpaque(px.t)) break;
  }
  const size_t plane = size_t(job.width) * job.height;
  const int rows = std::min(kTileSize, job.height - job.y0);
  const int cols = std::min(kTileSize, job.width - job.x0);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x) {
      const int i = y * kTileSize + x;
      const size_t to = size_t(job.y0 + y) * job.width + job.x0 + x;
      job.color[to] = px.r[i] + px.t[i] * job.background[0];
      job.color[plane + to] = px.g[i] + px.t[i] * job.background[1];
      job.color[2 * plane + to] = px.b[i] + px.t[i] * job.background[2];
      job.transmittance[to] = px.t[i];
    }
  return k;
}

struct alignas(64) TileVjpPixels {
  float t[kPixels], behind[kPixels], r[kPixels], g[kPixels], b[kPixels];  // r, g, b: d_color
};

void LoadVjpPixels(const TileJob& job, const float* d_color, TileVjpPixels& px) {
  StartTransmittance(job, px.t);
  const size_t plane = size_t(job.width) * job.height;
  for (int y = 0; y < kTileSize; ++y)
    for (int x = 0; x < kTileSize; ++x) {
      const int i = y * kTileSize + x;
      px.r[i] = px.g[i] = px.b[i] = px.behind[i] = 0;
      if (job.y0 + y >= job.height || job.x0 + x >= job.width) continue;
      const size_t from = size_t(job.y0 + y) * job.width + job.x0 + x;
      px.r[i] = d_color[from];
      px.g[i] = d_color[plane + from];
      px.b[i] = d_color[2 * plane + from];
      px.behind[i] = px.r[i] * job.color[from] + px.g[i] * job.color[plane + from] +
                     px.b[i] * job.color[2 * plane + from];
    }
}

SplatGradient BlendSplatVjp(const ProjectedSplat& s, const TileJob& job, TileVjpPixels& px) {
  const TileSpan span = SpanOf(s, job);
  const PowerForm<Pack> form = FormOf(s);
  const Vec3<Pack> color = ColorOfSplat(s);
  const Pack opacity(s.opacity), reject(s.reject_below), zero(0.0f);
  PowerMoments<Pack> moments{zero, zero, zero, zero, zero};
  Vec3<Pack> d_color{zero, zero, zero};
  Pack d_opacity = zero;
  for (int j = span.pack_begin; j < span.pack_end; ++j) {
    const Pack dx = Ramp(float(job.x0 + j * int(kLanes)) + 0.5f - s.x);
    for (int y = span.row_begin; y < span.row_end; ++y) {
      const Pack dy(float(job.y0 + y) + 0.5f - s.y);
      const Pack power = PowerAt(AtRow(form, dy), dx);
      const int at = y * kTileSize + j * int(kLanes);
      BlendVjpState<Pack> state{LoadPack(px.t + at), {}};
      const PackMask accept = Accepts(power, reject, state.transmittance);
      if (!AnyTrue(accept)) continue;
      state.behind = LoadPack(px.behind + at);
      const Vec3<Pack> d_pixel{LoadPack(px.r + at), LoadPack(px.g + at), LoadPack(px.b + at)};
      const Pack falloff = Exp(power);
      const BlendVjpResult<Pack> d =
          BlendBehindVjp(accept, AlphaOf(opacity, falloff), color, d_pixel, state);
      StorePack(state.transmittance, px.t + at);
      StorePack(state.behind, px.behind + at);
      d_color += d_pixel * d.weight;
      const Pack d_product = AlphaOfVjp(opacity, falloff, d.d_alpha) * falloff;
      d_opacity += d_product;
      Accumulate(d_product * opacity, dx, dy, moments);
    }
  }
  const PowerMoments<float> sums{
      Sum(moments.x), Sum(moments.y), Sum(moments.xx), Sum(moments.xy), Sum(moments.yy)};
  const Vec2<float> d_center =
      CenterVjp(PowerForm<float>{s.power_xx, s.power_xy, s.power_yy}, sums);
  return {d_center.x,
          d_center.y,
          sums.xx,
          sums.xy,
          sums.yy,
          Sum(d_opacity),
          Sum(d_color.x),
          Sum(d_color.y),
          Sum(d_color.z)};
}

void BackwardTile(const TileJob& job, const float* d_color, SplatGradient* records) {
  TileVjpPixels px;
  LoadVjpPixels(job, d_color, px);
  for (uint32_t k = 0; k < job.entry_count; ++k)
    records[job.entries[k].record] = BlendSplatVjp(job.splats[job.entries[k].gaussian], job, px);
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(ForwardTile);
HWY_EXPORT(BackwardTile);
}  // namespace math

uint32_t BlendTileForward(const TileJob& job) {
  using namespace math;
  return HWY_DYNAMIC_DISPATCH(ForwardTile)(job);
}

void BlendTileBackward(const TileJob& job, const float* d_color, SplatGradient* records) {
  using namespace math;
  HWY_DYNAMIC_DISPATCH(BackwardTile)(job, d_color, records);
}

}  // namespace cosplat
#endif
