#include "splat/render/cpu/blend_tile.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/render/cpu/blend_tile.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/render/cpu/tile_blocks.h"

COSPLAT_MATH_BEGIN

struct alignas(64) TilePixels {
  float t[kPixels], r[kPixels], g[kPixels], b[kPixels];
};

// Returns the parts with pixels that accept the splat.
template <int kExpDegree>
HWY_INLINE PartMask
BlendSplat(const ProjectedSplat& s, const TileGrid& grid, BlockMask open, TilePixels& px) {
  const SplatOnTile on(s, grid);
  const Vec3<Pack> color = ColorOfSplat(s);
  const Pack opacity(s.opacity), reject(s.reject_below), zero(0.0f);
  PartMask blended = 0;
  ForPacks(on.reached & open, [&](int block, int pack, int at) HWY_ATTR {
    const Pack power = on.PowerOf(block, pack, grid);
    BlendState<Pack> state{LoadPack(px.t + at), {}};
    const PackMask accept = Accepts(power, reject, state.transmittance);
    if (!AnyTrue(accept)) return;
    blended |= PartMask(1) << (at / kPartPixels);
    state.color = {LoadPack(px.r + at), LoadPack(px.g + at), LoadPack(px.b + at)};
    const Pack alpha = AlphaOf(opacity, FastExp<kExpDegree>(power));
    BlendBehind(Select(accept, alpha, zero), color, state);
    StorePack(state.transmittance, px.t + at);
    StorePack(state.color.x, px.r + at);
    StorePack(state.color.y, px.g + at);
    StorePack(state.color.z, px.b + at);
  });
  return blended;
}

template <int kExpDegree>
uint32_t Forward(const TileJob& job) {
  const TileGrid grid(job);
  TilePixels px;
  StartTransmittance(job, px.t);
  for (int i = 0; i < kPixels; ++i) px.r[i] = px.g[i] = px.b[i] = 0;
  uint32_t k = 0;
  while (k < job.entry_count) {
    const BlockMask open = OpenBlocks(px.t);
    if (open == 0) break;
    const uint32_t stop = std::min(k + uint32_t(kStopInterval), job.entry_count);
    for (; k < stop; ++k) job.blended[k] = BlendSplat<kExpDegree>(SplatAt(job, k), grid, open, px);
  }
  const size_t plane = size_t(job.width) * job.height;
  ForRowsOnImage(job, [&](int i, size_t at, int n) HWY_ATTR {
    for (int k = 0; k < n; ++k) {
      const float t = px.t[i + k];
      job.color[at + k] = px.r[i + k] + t * job.background[0];
      job.color[plane + at + k] = px.g[i + k] + t * job.background[1];
      job.color[2 * plane + at + k] = px.b[i + k] + t * job.background[2];
      job.transmittance[at + k] = t;
    }
  });
  return k;
}

struct alignas(64) TileVjpPixels {
  float t[kPixels], behind[kPixels], r[kPixels], g[kPixels], b[kPixels];  // r, g, b: d_color
};

void LoadVjpPixels(const TileJob& job, const float* d_color, TileVjpPixels& px) {
  StartTransmittance(job, px.t);
  for (float* p : {px.behind, px.r, px.g, px.b}) std::fill(p, p + kPixels, 0.0f);
  const size_t plane = size_t(job.width) * job.height;
  ForRowsOnImage(job, [&](int i, size_t at, int n) HWY_ATTR {
    for (int k = 0; k < n; ++k) {
      px.r[i + k] = d_color[at + k];
      px.g[i + k] = d_color[plane + at + k];
      px.b[i + k] = d_color[2 * plane + at + k];
      px.behind[i + k] = px.r[i + k] * job.color[at + k] + px.g[i + k] * job.color[plane + at + k] +
                         px.b[i + k] * job.color[2 * plane + at + k];
    }
  });
}

template <int kExpDegree>
HWY_INLINE SplatGradient
BlendSplatVjp(const ProjectedSplat& s, const TileGrid& grid, PartMask blended, TileVjpPixels& px) {
  if (blended == 0) return {};
  const SplatOnTile on(s, grid, blended);
  const Vec3<Pack> color = ColorOfSplat(s);
  const Pack opacity(s.opacity), reject(s.reject_below), zero(0.0f);
  // Accumulated about each pack's first pixel, whose offset is common to all lanes; shifted to the
  // lanes' own pixels at the end.
  PowerMoments<Pack> moments{zero, zero, zero, zero, zero, zero};
  Vec3<Pack> d_color{zero, zero, zero};
  ForPacksOfParts(blended, [&](int block, int pack, int at) HWY_ATTR {
    const Pack power = on.PowerOf(block, pack, grid);
    BlendVjpState<Pack> state{LoadPack(px.t + at), {}};
    const PackMask accept = Accepts(power, reject, state.transmittance);
    if (!AnyTrue(accept)) return;
    state.behind = LoadPack(px.behind + at);
    const Vec3<Pack> d_pixel{LoadPack(px.r + at), LoadPack(px.g + at), LoadPack(px.b + at)};
    const Pack falloff = Select(accept, FastExp<kExpDegree>(power), zero);
    const BlendVjpResult<Pack> d = BlendBehindVjp(AlphaOf(opacity, falloff), color, d_pixel, state);
    StorePack(state.transmittance, px.t + at);
    StorePack(state.behind, px.behind + at);
    d_color += d_pixel * d.weight;
    Accumulate(AlphaOfVjp(opacity, falloff, d.d_alpha) * falloff,
               Pack(on.dx[block] + float(pack * int(kLanes) % kBlockSize)),
               Pack(on.dy[block] + float(pack * int(kLanes) / kBlockSize)),
               moments);
  });
  // in_block starts with the pixel offsets in a block's first pack; they are the same in every
  // pack.
  moments = MomentsMovedBy(moments, LoadPack(grid.in_block_x), LoadPack(grid.in_block_y));
  const Pack lanes[9] = {moments.one,
                         moments.x,
                         moments.y,
                         moments.xx,
                         moments.xy,
                         moments.yy,
                         d_color.x,
                         d_color.y,
                         d_color.z};
  float sum[9];
  SumEach<9>(lanes, sum);
  const ShapeGradient<float> d =
      ShapeVjp(PowerForm<float>{s.power_xx, s.power_xy, s.power_yy},
               s.opacity,
               PowerMoments<float>{sum[0], sum[1], sum[2], sum[3], sum[4], sum[5]});
  return {d.x, d.y, d.power_xx, d.power_xy, d.power_yy, d.opacity, sum[6], sum[7], sum[8]};
}

template <int kExpDegree>
void Backward(const TileJob& job, const float* d_color, SplatGradient* records) {
  if (job.entry_count == 0) return;  // half of the tiles if an object is in front of a background
  const TileGrid grid(job);
  TileVjpPixels px;
  LoadVjpPixels(job, d_color, px);
  for (uint32_t k = 0; k < job.entry_count; ++k)
    records[job.entries[k].record] =
        BlendSplatVjp<kExpDegree>(SplatAt(job, k), grid, job.blended[k], px);
}

uint32_t ForwardTile(const TileJob& job) {
  switch (job.exp_degree) {
    case 2:
      return Forward<2>(job);
    case 3:
      return Forward<3>(job);
    case 4:
      return Forward<4>(job);
    default:
      return Forward<5>(job);
  }
}

void BackwardTile(const TileJob& job, const float* d_color, SplatGradient* records) {
  switch (job.exp_degree) {
    case 2:
      return Backward<2>(job, d_color, records);
    case 3:
      return Backward<3>(job, d_color, records);
    case 4:
      return Backward<4>(job, d_color, records);
    default:
      return Backward<5>(job, d_color, records);
  }
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
