#include "splat/density.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splat/base/error.h"
#include "splat/math/quat.h"
#include "splat/morton.h"
#include "splat/prune/pruner.h"
#include "splat/prune/select.h"
#include "splat/rasterizer.h"

namespace cosplat {
namespace {

constexpr float kSplitShrink = 1.6f;  // 3DGS: children's scale is the parent's over 0.8 * N, N = 2
constexpr float kResetOpacity = 0.01f;  // 3DGS

float LargestScale(const Gaussians& g, size_t i) {
  const float* s = g.at(kScaleLog, i);
  return std::exp(std::max({s[0], s[1], s[2]}));
}

bool AllFinite(const Gaussians& g, size_t i) {
  for (int a = 0; a < kAttributeCount; ++a)
    for (int k = 0; k < g.width(a); ++k)
      if (!std::isfinite(g.values[a][i * g.width(a) + k])) return false;
  return true;
}

// Gaussians whose mean screen gradient asks for more detail; at most `room`, the strongest.
std::vector<uint32_t> SelectForDensifying(const DensitySettings& settings,
                                          const DensityStatistics& statistics,
                                          size_t count) {
  std::vector<uint32_t> selected;
  std::vector<float> mean(count, 0.0f);
  for (size_t i = 0; i < count; ++i) {
    if (statistics.visible[i] > 0) mean[i] = statistics.screen_gradient[i] / statistics.visible[i];
    if (mean[i] >= settings.gradient_threshold) selected.push_back(uint32_t(i));
  }
  const size_t room = settings.max_count > count ? settings.max_count - count : 0;
  if (selected.size() > room) {
    std::stable_sort(selected.begin(), selected.end(), [&](uint32_t a, uint32_t b) {
      return mean[a] > mean[b];
    });
    selected.resize(room);
    std::sort(selected.begin(), selected.end());
  }
  return selected;
}

// A point drawn from the Gaussian itself, relative to its centre.
std::array<float, 3> SampleOffset(const Gaussians& g, size_t i, Rng& rng) {
  const float *q = g.at(kRotation, i), *s = g.at(kScaleLog, i);
  const math::Vec3<float> local{
      rng.Normal() * std::exp(s[0]), rng.Normal() * std::exp(s[1]), rng.Normal() * std::exp(s[2])};
  const math::Vec3<float> p =
      math::RotationOf(math::Normalize(math::Quat<float>{q[0], q[1], q[2], q[3]})) * local;
  return {p.x, p.y, p.z};
}

// Which of the Gaussians after cloning and splitting go, by opacity, size and broken numbers.
std::vector<uint8_t> MarkUnwanted(const DensitySettings& settings,
                                  bool remove_oversized,
                                  const Gaussians& gaussians,
                                  const Buffer<float>& max_radius,
                                  DensityReport& report) {
  const float min_logit = std::log(settings.min_opacity / (1 - settings.min_opacity));
  std::vector<uint8_t> unwanted(gaussians.size(), 0);
  for (size_t i = 0; i < gaussians.size(); ++i) {
    if (!AllFinite(gaussians, i)) {
      unwanted[i] = 1;
      ++report.broken;
    } else if (gaussians.at(kOpacityLogit, i)[0] < min_logit) {
      unwanted[i] = 1;
      ++report.transparent;
    } else if (remove_oversized && (max_radius[i] > settings.max_radius_px ||
                                    LargestScale(gaussians, i) > settings.max_scale)) {
      unwanted[i] = 1;
      ++report.oversized;
    }
  }
  return unwanted;
}

}  // namespace

void DensityStatistics::Reset(size_t n) {
  for (Buffer<float>* b : {&screen_gradient, &plasticity, &visible, &max_radius})
    *b = Buffer<float>(n, 0.0f);
}

void DensityStatistics::Gather(const Reordering& order) {
  for (Buffer<float>* b : {&screen_gradient, &plasticity, &visible, &max_radius}) {
    Buffer<float> gathered(order.source.size());
    for (size_t i = 0; i < gathered.size(); ++i) gathered[i] = (*b)[order.source[i]];
    for (const uint32_t i : order.fresh) gathered[i] = 0;
    *b = std::move(gathered);
  }
}

void DensityStatistics::Accumulate(const RenderTape& tape,
                                   const Buffer<float>& screen,
                                   const Buffer<float>& d_scale_log,
                                   const Buffer<float>& scale_log,
                                   int width,
                                   int height) {
  const View<const float> radii = tape.radii();
  tbb::parallel_for(tbb::blocked_range<size_t>(0, visible.size(), 4096), [&](const auto& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) {
      const float radius = radii[i];
      if (!(radius > 0)) continue;
      const float gx = screen[2 * i] * 0.5f * width, gy = screen[2 * i + 1] * 0.5f * height;
      const float screen_norm = std::sqrt(gx * gx + gy * gy);
      float square = 0;
      for (int k = 0; k < 3; ++k) {
        const float s = std::exp(scale_log[3 * i + k]);
        const float d = s > 0 ? d_scale_log[3 * i + k] / s : 0.0f;  // dL/ds, 0 with s
        square += d * d;
      }
      // A step with a broken gradient says nothing of this one (Adam ignores it, too).
      if (!std::isfinite(screen_norm) || !std::isfinite(square)) continue;
      screen_gradient[i] += screen_norm;
      plasticity[i] += std::sqrt(square);
      visible[i] += 1;
      max_radius[i] = std::max(max_radius[i], radius);
    }
  });
}

void Placement::Move(Gaussians& gaussians, uint32_t i, const std::array<float, 3>& offset) {
  for (int k = 0; k < 3; ++k) gaussians.at(kPosition, i)[k] += offset[k];
}

std::array<float, 3> Placement::Center(const Gaussians& gaussians, size_t i) const {
  const float* p = gaussians.at(kPosition, i);
  return {p[0], p[1], p[2]};
}

void Population::Gather(const Reordering& order) const {
  for (const int64_t step : adam.updated)
    if (step != adam.step) throw Error("", "density control", "Adam has not caught up");
  gaussians.Gather(order.source);
  placement.Gather(order.source);
  statistics.Gather(order);
  if (pruner) pruner->Gather(order);
  for (Gaussians* moments : {&adam.m, &adam.v}) {
    moments->Gather(order.source);
    for (int a = 0; a < kAttributeCount; ++a)
      for (const uint32_t i : order.fresh)
        std::fill_n(
            moments->values[a].begin() + size_t(i) * moments->width(a), moments->width(a), 0.0f);
  }
  adam.updated.assign(AdamGroupCount(order.source.size()), adam.step);
}

size_t Population::Remove(const std::vector<uint8_t>& unwanted) const {
  std::vector<uint32_t> removed;
  for (size_t i = 0; i < unwanted.size(); ++i)
    if (unwanted[i]) removed.push_back(uint32_t(i));
  if (removed.empty()) return 0;
  placement.Veto(gaussians, removed);
  Reordering remaining;
  auto next = removed.begin();
  for (uint32_t i = 0; i < gaussians.size(); ++i) {
    if (next != removed.end() && *next == i)
      ++next;
    else
      remaining.source.push_back(i);
  }
  Gather(remaining);
  return removed.size();
}

size_t Population::Prune(const PruneRound& round, int group_cap, int group_floor) const {
  std::vector<uint8_t> exempt = round.exempt;
  exempt.resize(gaussians.size(), 0);
  const std::vector<int32_t> groups = placement.Groups();
  std::vector<uint8_t> unwanted(gaussians.size(), 0);
  for (const uint32_t i :
       SelectForPruning({round.score, exempt, groups, round.remove, group_cap, group_floor}))
    unwanted[i] = 1;
  return Remove(unwanted);
}

DensityReport ControlDensity(const DensitySettings& settings,
                             bool remove_oversized,
                             const Population& population,
                             Rng& rng) {
  DensityReport report;
  Gaussians& gaussians = population.gaussians;
  const size_t before = gaussians.size();
  const std::vector<uint32_t> selected =
      SelectForDensifying(settings, population.statistics, before);
  std::vector<uint8_t> is_split(before, 0);
  std::vector<uint32_t> clones, splits;
  for (const uint32_t i : selected) {
    const bool split = LargestScale(gaussians, i) > settings.split_scale;
    is_split[i] = split;
    (split ? splits : clones).push_back(i);
  }
  report.cloned = clones.size();
  report.split = splits.size();

  Reordering order;
  for (size_t i = 0; i < before; ++i)
    if (!is_split[i]) order.source.push_back(uint32_t(i));
  const size_t kept = order.source.size();
  order.source.insert(order.source.end(), clones.begin(), clones.end());
  const size_t children = order.source.size();
  for (const uint32_t i : splits) order.source.insert(order.source.end(), {i, i});
  order.fresh.resize(order.source.size() - kept);
  std::iota(order.fresh.begin(), order.fresh.end(), uint32_t(kept));
  population.Gather(order);

  for (size_t i = children; i < gaussians.size(); ++i) {
    const std::array<float, 3> offset = SampleOffset(gaussians, i, rng);
    population.placement.Move(gaussians, uint32_t(i), offset);
    for (int k = 0; k < 3; ++k) gaussians.at(kScaleLog, i)[k] -= std::log(kSplitShrink);
  }
  population.Remove(MarkUnwanted(
      settings, remove_oversized, gaussians, population.statistics.max_radius, report));
  return report;
}

void SortInSpace(const Population& population) {
  std::vector<std::array<float, 3>> centers(population.gaussians.size());
  for (size_t i = 0; i < centers.size(); ++i)
    centers[i] = population.placement.Center(population.gaussians, i);
  population.Gather({MortonOrder(centers), {}});
}

void ResetOpacity(Gaussians& gaussians, AdamState& adam) {
  const float limit = std::log(kResetOpacity / (1 - kResetOpacity));
  for (float& logit : gaussians.values[kOpacityLogit]) logit = std::min(logit, limit);
  for (Gaussians* moments : {&adam.m, &adam.v})
    std::fill(moments->values[kOpacityLogit].begin(), moments->values[kOpacityLogit].end(), 0.0f);
}

}  // namespace cosplat
