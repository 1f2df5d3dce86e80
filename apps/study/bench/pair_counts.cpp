#include <algorithm>
#include <array>
#include <cmath>

#include "apps/study/bench/bench_scene.h"
#include "splat/config.h"
#include "splat/math/blend.h"
#include "splat/render/cpu/launch.h"
#include "splat/render/rasterizer.h"
#include "splat/train/optimize/optimizer.h"

namespace cosplat {
namespace {

struct Projected {
  Buffer<ProjectedSplat> splats;
  Buffer<float> radii;
};
Projected Project(const Gaussians& gaussians, const Camera& camera) {
  Projected p{Buffer<ProjectedSplat>(gaussians.size()), Buffer<float>(gaussians.size())};
  LaunchProject(ViewOf(gaussians),
                ViewOfCamera(camera, gaussians.basis, gaussians.degree),
                p.splats.data(),
                p.radii.data());
  return p;
}

// Part of a tile and the transmittance of its pixels, 0 beyond the image.
struct Block {
  float x0, y0;  // centre of its first pixel
  std::array<float, kBlockSize * kBlockSize> transmittance;

  bool Open() const {
    return *std::max_element(transmittance.begin(), transmittance.end()) >= kMinTransmittance;
  }
  void Add(const ProjectedSplat& s, PairCounts& counts) {
    const math::PowerForm<float> form{s.power_xx, s.power_xy, s.power_yy};
    const float dx = x0 - s.x, dy = y0 - s.y, last = kBlockSize - 1;
    if (LargestPowerIn(form, RidgesOf(form), dx, dx + last, dy, dy + last) < s.reject_below) return;
    for (int i = 0; i < kBlockSize * kBlockSize; ++i) {
      float& t = transmittance[i];
      const float power = PowerAt(form, dx + float(i % kBlockSize), dy + float(i / kBlockSize));
      ++counts.evaluated;
      if (!math::Accepts(power, s.reject_below, t)) continue;
      ++counts.contributing;
      t -= t * math::AlphaOf(s.opacity, std::exp(power));
    }
  }
};

// The block with this first pixel.
Block BlockAt(int x0, int y0, const Camera& camera) {
  Block block{float(x0) + 0.5f, float(y0) + 0.5f, {}};
  for (int i = 0; i < kBlockSize * kBlockSize; ++i)
    if (x0 + i % kBlockSize < camera.width && y0 + i / kBlockSize < camera.height)
      block.transmittance[i] = 1;
  return block;
}

}  // namespace

PairCounts CountPairs(const Gaussians& gaussians, const Camera& camera) {
  const Projected projected = Project(gaussians, camera);
  TileLists lists;
  lists.Build(projected.splats, projected.radii, camera.width, camera.height);
  PairCounts counts;
  for (int y = 0; y < camera.height; y += kBlockSize)
    for (int x = 0; x < camera.width; x += kBlockSize) {
      const int tile = y / kTileSize * lists.tiles_x + x / kTileSize;
      Block block = BlockAt(x, y, camera);
      const uint32_t begin = lists.tile_begin[tile];
      for (uint32_t k = begin; k < lists.tile_begin[tile + 1]; ++k) {
        if ((k - begin) % kStopInterval == 0 && !block.Open()) break;
        block.Add(projected.splats[lists.entries[k].gaussian], counts);
      }
    }
  return counts;
}

}  // namespace cosplat
