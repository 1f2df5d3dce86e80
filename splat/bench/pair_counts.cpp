#include "splat/bench/pair_counts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "splat/basis_constants.h"
#include "splat/config.h"
#include "splat/cpu/launch.h"
#include "splat/math/blend.h"
#include "splat/rasterizer.h"

namespace cosplat {
namespace {

constexpr int kPixels = kTileSize * kTileSize;

ViewParameters ParametersOf(const Camera& camera, const Gaussians& gaussians) {
  ViewParameters v{};
  std::copy(camera.rotation.begin(), camera.rotation.end(), v.rotation);
  std::copy(camera.translation.begin(), camera.translation.end(), v.translation);
  const std::array<float, 3> center = camera.Center();
  std::copy(center.begin(), center.end(), v.center);
  v.fx = camera.fx;
  v.fy = camera.fy;
  v.cx = camera.cx;
  v.cy = camera.cy;
  v.width = float(camera.width);
  v.height = float(camera.height);
  v.basis_constants = BasisConstants(gaussians.basis);
  v.degree = gaussians.degree;
  return v;
}

// First and one past the last of `count` pixel centres within [center - half, center + half].
std::array<int, 2> CentersWithin(float center, float half, int count) {
  const auto clamped = [count](float v) { return int(std::clamp(v, 0.0f, float(count))); };
  return {clamped(std::ceil(center - half - 0.5f)), clamped(std::floor(center + half + 0.5f))};
}

// The part of an image that one tile covers, and how opaque its pixels are.
struct Tile {
  int x0, y0, width, height;
  std::array<float, kPixels> transmittance;

  bool Opaque() const {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (transmittance[y * kTileSize + x] >= kMinTransmittance) return false;
    return true;
  }
  void Add(const ProjectedSplat& s, PairCounts& counts) {
    const auto [left, right] = CentersWithin(s.x - float(x0), s.half_x, width);
    const auto [top, bottom] = CentersWithin(s.y - float(y0), s.half_y, height);
    const math::PowerForm<float> form{s.power_xx, s.power_xy, s.power_yy};
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) {
        float& t = transmittance[y * kTileSize + x];
        const float power = PowerAt(form, float(x0 + x) + 0.5f - s.x, float(y0 + y) + 0.5f - s.y);
        ++counts.evaluated;
        if (!math::Accepts(power, s.reject_below, t)) continue;
        ++counts.contributing;
        t -= t * math::AlphaOf(s.opacity, std::exp(power));
      }
  }
};

}  // namespace

PairCounts CountPairs(const Gaussians& gaussians, const Camera& camera) {
  Buffer<ProjectedSplat> splats(gaussians.size());
  LaunchProject(ViewOf(gaussians), ParametersOf(camera, gaussians), splats.data());
  TileLists lists;
  lists.Build(splats, camera.width, camera.height);
  PairCounts counts;
  for (int i = 0; i < lists.tiles_x * lists.tiles_y; ++i) {
    Tile tile{i % lists.tiles_x * kTileSize, i / lists.tiles_x * kTileSize, 0, 0, {}};
    tile.width = std::min(kTileSize, camera.width - tile.x0);
    tile.height = std::min(kTileSize, camera.height - tile.y0);
    tile.transmittance.fill(1);
    for (uint32_t k = lists.tile_begin[i]; k < lists.tile_begin[i + 1] && !tile.Opaque(); ++k)
      tile.Add(splats[lists.entries[k].gaussian], counts);
  }
  return counts;
}

}  // namespace cosplat
