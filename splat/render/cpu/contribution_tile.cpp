#include <algorithm>

#include "splat/render/cpu/blend_tile.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/render/cpu/contribution_tile.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/render/cpu/tile_blocks.h"

COSPLAT_MATH_BEGIN

// Per pixel: the transmittance, and the colour from behind the splats so far.
struct alignas(64) ContributionPixels {
  float t[kPixels], behind[3][kPixels];
};

void LoadContributionPixels(const TileJob& job, ContributionPixels& px) {
  StartTransmittance(job, px.t);
  const size_t plane = size_t(job.width) * job.height;
  for (int c = 0; c < 3; ++c) {
    std::fill(px.behind[c], px.behind[c] + kPixels, 0.0f);
    ForRowsOnImage(job, [&](int i, size_t at, int n) HWY_ATTR {
      for (int k = 0; k < n; ++k) px.behind[c][i + k] = job.color[c * plane + at + k];
    });
  }
}

HWY_INLINE Vec3<Pack> LoadVec3At(const float (&planes)[3][kPixels], int at) {
  return {LoadPack(planes[0] + at), LoadPack(planes[1] + at), LoadPack(planes[2] + at)};
}

HWY_INLINE Contribution SumOfSplat(const ProjectedSplat& s,
                                   const TileGrid& grid,
                                   BlockMask open,
                                   ContributionPixels& px) {
  const SplatOnTile on(s, grid);
  const Vec3<Pack> color = ColorOfSplat(s);
  const Pack opacity(s.opacity), reject(s.reject_below), zero(0.0f);
  Pack sums[4] = {zero, zero, zero, zero};
  ForPacks(on.reached & open, [&](int block, int pack, int at) HWY_ATTR {
    const Pack power = on.PowerOf(block, pack, grid);
    Pack t = LoadPack(px.t + at);
    const PackMask accept = Accepts(power, reject, t);
    if (!AnyTrue(accept)) return;
    const Pack falloff = Select(accept, FastExp<kMaxExpDegree>(power), zero);
    Vec3<Pack> behind = LoadVec3At(px.behind, at);
    const PixelContribution<Pack> c =
        ContributionBehind(accept, opacity, falloff, color, behind, t);
    StorePack(t, px.t + at);
    StorePack(behind.x, px.behind[0] + at);
    StorePack(behind.y, px.behind[1] + at);
    StorePack(behind.z, px.behind[2] + at);
    sums[0] += c.weight;
    sums[1] += c.hits;
    sums[2] += c.sensitivity;
    sums[3] += c.change;
  });
  float sum[4];
  SumEach<4>(sums, sum);
  return {sum[0], s.opacity * sum[1], sum[2], sum[3]};
}

void SumContributionsOfTile(const TileJob& job, Contribution* records) {
  const TileGrid grid(job);
  ContributionPixels px;
  LoadContributionPixels(job, px);
  for (uint32_t k = 0; k < job.entry_count;) {
    const BlockMask open = OpenBlocks(px.t);
    const uint32_t stop = std::min(k + uint32_t(kStopInterval), job.entry_count);
    for (; k < stop; ++k)
      records[job.entries[k].record] = SumOfSplat(SplatAt(job, k), grid, open, px);
  }
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(SumContributionsOfTile);
}  // namespace math

void SumContributions(const TileJob& job, Contribution* records) {
  using namespace math;
  HWY_DYNAMIC_DISPATCH(SumContributionsOfTile)(job, records);
}

}  // namespace cosplat
#endif
