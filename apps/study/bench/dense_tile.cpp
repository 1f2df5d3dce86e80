#include "apps/study/bench/dense_tile.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/study/bench/measure.h"
#include "splat/base/rng.h"
#include "splat/math/blend.h"
#include "splat/render/cpu/blend_tile.h"

namespace cosplat {
namespace {

constexpr int kSplats = 128, kPixels = kTileSize * kTileSize;

// Every pixel accepts every splat, and none is opaque at the end.
std::vector<ProjectedSplat> DenseSplats() {
  Rng rng{1};
  std::vector<ProjectedSplat> splats(kSplats);
  for (ProjectedSplat& s : splats) {
    const float sigma = 20 + 10 * rng.Uniform();
    s.x = kTileSize * rng.Uniform();
    s.y = kTileSize * rng.Uniform();
    s.power_xx = s.power_yy = -0.5f / (sigma * sigma);
    s.power_xy = 0.3f * s.power_xx;
    s.x_per_y = s.y_per_x = -0.15f;
    s.opacity = 0.02f + 0.06f * rng.Uniform();
    s.reject_below = math::RejectBelow(s.opacity);
    s.r = rng.Uniform();
    s.g = rng.Uniform();
    s.b = rng.Uniform();
    s.half_x = s.half_y = 100;
    s.depth = 1;
  }
  return splats;
}

struct Tile {
  std::vector<ProjectedSplat> splats = DenseSplats();
  std::vector<TileEntry> entries;
  Buffer<float> color = Buffer<float>(3 * kPixels), d_color = color;
  Buffer<float> transmittance = Buffer<float>(kPixels);
  std::vector<uint32_t> blended = std::vector<uint32_t>(kSplats);
  std::vector<SplatGradient> records = std::vector<SplatGradient>(kSplats);

  Tile() {
    for (uint32_t i = 0; i < kSplats; ++i) entries.push_back({i, i});
    Rng rng{2};
    for (float& d : d_color) d = rng.Uniform() - 0.5f;
  }
  TileJob Job() {
    TileJob job;
    job.splats = splats.data();
    job.entries = entries.data();
    job.entry_count = kSplats;
    job.blended = blended.data();
    job.width = job.height = kTileSize;
    job.color = color.data();
    job.transmittance = transmittance.data();
    return job;
  }
};

// The same formulas with T = float, one pixel at a time.
void ScalarForward(Tile& tile) {
  for (int y = 0; y < kTileSize; ++y)
    for (int x = 0; x < kTileSize; ++x) {
      math::BlendState<float> state{1, {0, 0, 0}};
      for (const ProjectedSplat& s : tile.splats) {
        const math::PowerForm<float> form{s.power_xx, s.power_xy, s.power_yy};
        const float power = PowerAt(form, x + 0.5f - s.x, y + 0.5f - s.y);
        if (!math::Accepts(power, s.reject_below, state.transmittance)) continue;
        BlendBehind(
            math::AlphaOf(s.opacity, std::exp(power)), math::Vec3<float>{s.r, s.g, s.b}, state);
      }
      const int i = y * kTileSize + x;
      tile.color[i] = state.color.x;
      tile.color[kPixels + i] = state.color.y;
      tile.color[2 * kPixels + i] = state.color.z;
      tile.transmittance[i] = state.transmittance;
    }
}

void ScalarBackward(Tile& tile) {
  std::fill(tile.records.begin(), tile.records.end(), SplatGradient{});
  for (int y = 0; y < kTileSize; ++y)
    for (int x = 0; x < kTileSize; ++x) {
      const int i = y * kTileSize + x;
      const math::Vec3<float> d{
          tile.d_color[i], tile.d_color[kPixels + i], tile.d_color[2 * kPixels + i]};
      math::BlendVjpState<float> state{
          1,
          d.x * tile.color[i] + d.y * tile.color[kPixels + i] + d.z * tile.color[2 * kPixels + i]};
      for (int k = 0; k < kSplats; ++k) {
        const ProjectedSplat& s = tile.splats[k];
        const math::PowerForm<float> form{s.power_xx, s.power_xy, s.power_yy};
        const float dx = x + 0.5f - s.x, dy = y + 0.5f - s.y;
        const float power = PowerAt(form, dx, dy);
        if (!math::Accepts(power, s.reject_below, state.transmittance)) continue;
        const float falloff = std::exp(power);
        const auto result = BlendBehindVjp(
            math::AlphaOf(s.opacity, falloff), math::Vec3<float>{s.r, s.g, s.b}, d, state);
        const float d_product = math::AlphaOfVjp(s.opacity, falloff, result.d_alpha) * falloff;
        math::PowerMoments<float> moments{0, 0, 0, 0, 0, 0};
        Accumulate(d_product, dx, dy, moments);
        const math::ShapeGradient<float> shape = ShapeVjp(form, s.opacity, moments);
        SplatGradient& g = tile.records[k];
        g.x += shape.x;
        g.y += shape.y;
        g.power_xx += shape.power_xx;
        g.power_xy += shape.power_xy;
        g.power_yy += shape.power_yy;
        g.opacity += shape.opacity;
        g.r += result.weight * d.x;
        g.g += result.weight * d.y;
        g.b += result.weight * d.z;
      }
    }
}

double Sum(const Tile& tile) {
  double sum = 0;
  for (const float c : tile.color) sum += c;
  for (const SplatGradient& g : tile.records) sum += g.x + g.power_xy + g.opacity + g.r;
  return sum;
}

// One batch is 60 runs: two million pairs, milliseconds.
template <class Forward, class Backward>
BlendTimes Measure(int batches, Tile& tile, const Forward& forward, const Backward& backward) {
  constexpr int kRuns = 60;
  constexpr double kPairs = double(kSplats) * kPixels;
  BlendTimes times;
  times.forward_ns = 1e9 / kPairs * FastestSeconds(batches, kRuns, forward);
  times.backward_ns = 1e9 / kPairs * FastestSeconds(batches, kRuns, backward);
  times.checksum = Sum(tile);
  return times;
}

}  // namespace

BlendTimes MeasureBlend(int batches) {
  Tile tile;
  return Measure(
      batches,
      tile,
      [&] { BlendTileForward(tile.Job()); },
      [&] { BlendTileBackward(tile.Job(), tile.d_color.data(), tile.records.data()); });
}

BlendTimes MeasureScalarBlend(int batches) {
  Tile tile;
  return Measure(
      batches, tile, [&] { ScalarForward(tile); }, [&] { ScalarBackward(tile); });
}

}  // namespace cosplat
