#include "splat/levels/scene_levels.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/config.h"
#include "splat/levels/merge.h"
#include "splat/math/scalar.h"

namespace cosplat {
namespace {

// Standard deviations at which the most opaque Gaussian falls below kMinAlpha, rounded up.
constexpr float kReach = 3.34f;

struct PlacedGaussian {
  std::array<float, 3> at;
  uint32_t index;
};

int WidestAxis(const PlacedGaussian* places, size_t count) {
  std::array<double, 3> sum{}, squares{};
  for (size_t i = 0; i < count; ++i)
    for (size_t k = 0; k < 3; ++k) {
      const double x = double(places[i].at[k]) - double(places[0].at[k]);
      sum[k] += x;
      squares[k] += x * x;
    }
  std::array<double, 3> variance;
  for (size_t k = 0; k < 3; ++k) variance[k] = squares[k] - sum[k] * sum[k] / double(count);
  return int(std::max_element(variance.begin(), variance.end()) - variance.begin());
}

// Orders places so that every aligned range of a power of two of them is a cell of a k-d tree.
void SortIntoCells(PlacedGaussian* places, size_t count) {
  if (count <= 2) return;
  size_t left = 1;
  while (2 * left < count) left *= 2;
  const auto axis = size_t(WidestAxis(places, count));
  std::nth_element(places,
                   places + left,
                   places + count,
                   [axis](const PlacedGaussian& a, const PlacedGaussian& b) {
                     return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : a.index < b.index;
                   });
  constexpr size_t kAlone = 8192;
  if (count <= kAlone) {
    SortIntoCells(places, left);
    SortIntoCells(places + left, count - left);
  } else {
    tbb::parallel_invoke([=] { SortIntoCells(places, left); },
                         [=] { SortIntoCells(places + left, count - left); });
  }
}

bool IsRendered(const Gaussians& g, size_t i) {
  for (int a = 0; a < kAttributeCount; ++a)
    for (int k = 0; k < g.width(a); ++k)
      if (!std::isfinite(g.values[a][i * size_t(g.width(a)) + size_t(k)])) return false;
  const float *p = g.at(kPosition, i), *s = g.at(kScaleLog, i), *q = g.at(kRotation, i);
  return std::max({s[0], s[1], s[2]}) <= kMaxLevelScaleLog &&
         std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}) <= kMaxLevelPosition &&
         q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] > kMinQuaternionNorm2 &&
         *g.at(kOpacityLogit, i) >= math::Logit(kMinAlpha);
}

// The order of level 0.
std::vector<PlacedGaussian> PlacesOf(const Gaussians& scene) {
  std::vector<PlacedGaussian> places;
  places.reserve(scene.size());
  for (size_t i = 0; i < scene.size(); ++i) {
    const float* p = scene.at(kPosition, i);
    if (IsRendered(scene, i)) places.push_back({{p[0], p[1], p[2]}, uint32_t(i)});
  }
  SortIntoCells(places.data(), places.size());
  return places;
}

size_t BlocksOf(size_t count) { return (count + kLevelBlock - 1) / kLevelBlock; }

// Writes the levels one after the other into the values of a SceneLevels.
class Builder {
 public:
  Builder(SceneLevels& levels, float* values) : levels_(levels), values_(values) {
    for (int a = 0; a < kAttributeCount; ++a) widths_[a] = size_t(levels.layout.width(a));
  }

  void CopyFinest(const Gaussians& scene, const std::vector<PlacedGaussian>& places) {
    tbb::parallel_for(size_t(0), places.size(), [&](size_t i) {
      const OneGaussian<float> to = At(0, i);
      for (int a = 0; a < kAttributeCount; ++a)
        std::copy_n(
            scene.values[a].data() + places[i].index * widths_[a], widths_[a], to.values[a]);
    });
    lost_.assign(places.size(), 0.0f);
    Describe(0, places.size());
  }

  // Level of `count` Gaussians from block `from` on -> the next one, from block `to` on.
  void Halve(size_t from, size_t count, size_t to) {
    std::vector<float> lost((count + 1) / 2);
    tbb::parallel_for(size_t(0), lost.size(), [&](size_t i) {
      const OneGaussian<float> out = At(to, i);
      const OneGaussian<const float> a = ConstAt(from, 2 * i);
      if (2 * i + 1 == count) {
        for (int k = 0; k < kAttributeCount; ++k)
          std::copy_n(a.values[k], widths_[k], out.values[k]);
        lost[i] = lost_[2 * i];
        return;
      }
      const Merged merged = MergeTwo(a, ConstAt(from, 2 * i + 1), widths_, out);
      lost[i] = float(merged.lost + (1 - merged.share) * double(lost_[2 * i]) +
                      merged.share * double(lost_[2 * i + 1]));
    });
    lost_ = std::move(lost);
    Describe(to, lost_.size());
    for (size_t b = to; b < to + BlocksOf(lost_.size()); ++b) {
      LevelBlock& block = levels_.blocks[b];
      // A light Gaussian far from a heavy one may lie outside of what stands for both, and matter
      // less to the mean.
      for (uint32_t c = block.first_child; c < block.first_child + block.children; ++c) {
        const LevelBlock& child = levels_.blocks[c];
        block.coarseness = std::max(block.coarseness, child.coarseness);
        for (size_t k = 0; k < 3; ++k) {
          block.min[k] = std::min(block.min[k], child.min[k]);
          block.max[k] = std::max(block.max[k], child.max[k]);
        }
      }
    }
  }

 private:
  // Gaussian i of the level that begins with a block.
  OneGaussian<float> At(size_t first_block, size_t i) const {
    const size_t block = first_block + i / kLevelBlock, row = i % kLevelBlock;
    OneGaussian<float> one;
    float* at = values_ + levels_.offsets[block];
    for (int a = 0; a < kAttributeCount; ++a) {
      one.values[a] = at + row * widths_[a];
      at += levels_.blocks[block].count * widths_[a];
    }
    return one;
  }
  OneGaussian<const float> ConstAt(size_t first_block, size_t i) const {
    const OneGaussian<float> one = At(first_block, i);
    OneGaussian<const float> same;
    std::copy_n(one.values, int(kAttributeCount), same.values);
    return same;
  }

  // Bounds and coarseness of a level's blocks.
  void Describe(size_t first_block, size_t count) {
    tbb::parallel_for(size_t(0), BlocksOf(count), [&](size_t b) {
      LevelBlock& block = levels_.blocks[first_block + b];
      block.min.fill(std::numeric_limits<float>::max());
      block.max.fill(std::numeric_limits<float>::lowest());
      double lost = 0, sum = 0;
      for (size_t i = b * kLevelBlock; i < b * kLevelBlock + block.count; ++i) {
        const OneGaussian<const float> g = ConstAt(first_block, i);
        const float* log_scale = g.values[kScaleLog];
        const float reach = kReach * std::exp(std::max({log_scale[0], log_scale[1], log_scale[2]}));
        for (size_t k = 0; k < 3; ++k) {
          block.min[k] = std::min(block.min[k], g.values[kPosition][k] - reach);
          block.max[k] = std::max(block.max[k], g.values[kPosition][k] + reach);
        }
        const double weight = Coverage(g);
        lost += weight * double(lost_[i]);
        sum += weight;
      }
      block.coarseness = sum > 0 ? float(std::sqrt(lost / sum)) : 0.0f;
    });
  }

  SceneLevels& levels_;
  float* values_;
  size_t widths_[kAttributeCount];
  std::vector<float> lost_;  // of the level made last: mean square distances, world units^2
};

}  // namespace

size_t SceneLevels::width() const {
  size_t sum = 0;
  for (int a = 0; a < kAttributeCount; ++a) sum += size_t(layout.width(a));
  return sum;
}

size_t SceneLevels::size() const {
  size_t sum = 0;
  for (const LevelBlock& block : blocks) {
    if (block.children > 0) break;  // the finest blocks come first
    sum += block.count;
  }
  return sum;
}

void SceneLevels::CheckValues(size_t block) const {
  const size_t bytes = blocks[block].count * width() * sizeof(float);
  if (!checksums.empty() && Crc32(ValuesOf(block), bytes) != checksums[block])
    throw Error(file, "blocks[" + std::to_string(block) + "]", "has damaged values");
}

Gaussians SceneLevels::Coarsest() const {
  Gaussians g = layout;
  if (blocks.empty()) return g;
  CheckValues(blocks.size() - 1);
  g.Resize(blocks.back().count);
  const float* from = ValuesOf(blocks.size() - 1);
  for (Buffer<float>& values : g.values) {
    std::copy_n(from, values.size(), values.data());
    from += values.size();
  }
  return g;
}

uint64_t SceneLevels::LayOut(size_t gaussians) {
  blocks.clear();
  offsets.clear();
  uint64_t at = 0;
  size_t finer = 0;  // the first block of the finer level
  for (size_t count = gaussians; count > 0; count = (count + 1) / 2) {
    const size_t begin = blocks.size();
    for (size_t row = 0; row < count; row += kLevelBlock) {
      LevelBlock& block = blocks.emplace_back();
      block.count = uint32_t(std::min(kLevelBlock, count - row));
      if (begin > 0) {
        block.first_child = uint32_t(finer + 2 * (row / kLevelBlock));
        block.children = uint32_t(std::min<size_t>(2, begin - block.first_child));
      }
      offsets.push_back(at);
      at += block.count * width();
    }
    finer = begin;
    if (count <= kLevelBlock) break;
  }
  return at;
}

SceneLevels BuildLevels(Gaussians scene) {
  if (!scene.smoothing.empty())
    throw Error("scene", "smoothing", "must be part of scale and opacity before levels are made");
  SceneLevels levels;
  levels.layout.degree = scene.degree;
  levels.layout.basis = scene.basis;
  levels.layout.antialiased = scene.antialiased;
  levels.layout.low_pass_variance = scene.low_pass_variance;
  const std::vector<PlacedGaussian> places = PlacesOf(scene);
  if (places.empty()) return levels;
  const std::shared_ptr<float[]> values(new float[levels.LayOut(places.size())]);
  Builder builder(levels, values.get());
  builder.CopyFinest(scene, places);
  scene = {};
  for (size_t from = 0, count = places.size(); count > kLevelBlock; count = (count + 1) / 2) {
    const size_t to = from + BlocksOf(count);
    builder.Halve(from, count, to);
    from = to;
  }
  levels.values = std::shared_ptr<const float>(values, values.get());
  return levels;
}

}  // namespace cosplat
