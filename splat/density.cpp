#include "splat/density.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splat/base/error.h"
#include "splat/math/quat.h"
#include "splat/morton.h"
#include "splat/prune.h"
#include "splat/rasterizer.h"

namespace cosplat {
namespace {

constexpr float kSplitShrink = 1.6f;  // 3DGS: children's scale is the parent's over 0.8 * N, N = 2
constexpr float kResetOpacity = 0.01f;        // 3DGS
constexpr uint32_t kNew = uint32_t(1) << 31;  // marks a source entry whose moments start at zero

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

// Reorders everything that is per Gaussian. Entries with kNew get zero moments; Adam has put
// nothing off.
void GatherAll(std::vector<uint32_t> source,
               Placement& placement,
               Gaussians& gaussians,
               AdamState& adam) {
  for (const int64_t step : adam.updated)
    if (step != adam.step) throw Error("", "density control", "Adam has not caught up");
  std::vector<uint32_t> fresh;
  for (size_t i = 0; i < source.size(); ++i)
    if (source[i] & kNew) {
      source[i] &= ~kNew;
      fresh.push_back(uint32_t(i));
    }
  gaussians.Gather(source);
  placement.Gather(source);
  for (Gaussians* moments : {&adam.m, &adam.v}) {
    moments->Gather(source);
    for (int a = 0; a < kAttributeCount; ++a)
      for (const uint32_t i : fresh)
        std::fill_n(
            moments->values[a].begin() + size_t(i) * moments->width(a), moments->width(a), 0.0f);
  }
  adam.updated.assign(AdamGroupCount(source.size()), adam.step);
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
                                  const std::vector<float>& max_radius,
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

// How many go for their score, of `count`.
size_t CountToRemove(const DensitySettings& settings, size_t count, int rounds_left) {
  if (!settings.prune_by_plasticity) return 0;
  if (settings.prune_to == 0) return size_t(settings.prune_fraction * float(count));
  if (count <= settings.prune_to) return 0;
  // The same ratio each round reaches the target in the last one.
  const double ratio = std::pow(double(settings.prune_to) / double(count), 1.0 / (rounds_left + 1));
  return count - std::max(settings.prune_to, size_t(std::llround(count * ratio)));
}

// Marks what pruning takes of those that would stay; returns how many. The others do not fill a
// group or the budget.
size_t MarkUnplastic(const DensitySettings& settings,
                     int rounds_left,
                     const std::vector<int32_t>& groups,
                     const std::vector<float>& score,
                     const std::vector<uint8_t>& exempt,
                     std::vector<uint8_t>& unwanted) {
  std::vector<uint32_t> index;
  std::vector<float> score_of;
  std::vector<uint8_t> exempt_of;
  std::vector<int32_t> group_of;
  for (size_t i = 0; i < unwanted.size(); ++i) {
    if (unwanted[i]) continue;
    index.push_back(uint32_t(i));
    score_of.push_back(score[i]);
    exempt_of.push_back(exempt[i]);
    if (!groups.empty()) group_of.push_back(groups[i]);
  }
  const PruneRequest request{score_of,
                             exempt_of,
                             group_of,
                             CountToRemove(settings, index.size(), rounds_left),
                             settings.group_cap,
                             settings.group_floor};
  const std::vector<uint32_t> selected = SelectForPruning(request);
  for (const uint32_t k : selected) unwanted[index[k]] = 1;
  return selected.size();
}

}  // namespace

void DensityStatistics::Reset(size_t n) {
  for (Buffer<float>* b : {&screen_gradient, &plasticity, &visible, &max_radius})
    *b = Buffer<float>(n, 0.0f);
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

DensityReport ControlDensity(const DensitySettings& settings,
                             bool remove_oversized,
                             int rounds_left,
                             Placement& placement,
                             Gaussians& gaussians,
                             AdamState& adam,
                             DensityStatistics& statistics,
                             Rng& rng) {
  DensityReport report;
  const size_t before = gaussians.size();
  const std::vector<uint32_t> selected = SelectForDensifying(settings, statistics, before);
  std::vector<uint8_t> is_split(before, 0);
  std::vector<uint32_t> clones, splits;
  for (const uint32_t i : selected) {
    const bool split = LargestScale(gaussians, i) > settings.split_scale;
    is_split[i] = split;
    (split ? splits : clones).push_back(i);
  }
  report.cloned = clones.size();
  report.split = splits.size();

  std::vector<uint32_t> source;
  for (size_t i = 0; i < before; ++i)
    if (!is_split[i]) source.push_back(uint32_t(i));
  const size_t kept = source.size();
  for (const uint32_t i : clones) source.push_back(i | kNew);
  const size_t children = source.size();
  for (const uint32_t i : splits) source.insert(source.end(), {i | kNew, i | kNew});

  std::vector<float> score(source.size(), 0.0f), max_radius(source.size(), 0.0f);
  std::vector<uint8_t> exempt(source.size(), 1);
  for (size_t i = 0; i < kept; ++i) {
    const float steps = statistics.visible[source[i]];
    max_radius[i] = statistics.max_radius[source[i]];
    if (!(steps > 0)) continue;
    score[i] = statistics.plasticity[source[i]] / steps;
    exempt[i] = 0;
  }
  GatherAll(source, placement, gaussians, adam);
  for (size_t i = children; i < gaussians.size(); ++i) {
    const std::array<float, 3> offset = SampleOffset(gaussians, i, rng);
    placement.Move(gaussians, uint32_t(i), offset);
    for (int k = 0; k < 3; ++k) gaussians.at(kScaleLog, i)[k] -= std::log(kSplitShrink);
  }

  std::vector<uint8_t> unwanted =
      MarkUnwanted(settings, remove_oversized, gaussians, max_radius, report);
  if (settings.prune_by_plasticity || settings.group_cap > 0)
    report.unplastic =
        MarkUnplastic(settings, rounds_left, placement.Groups(), score, exempt, unwanted);
  std::vector<uint32_t> removed;
  for (size_t i = 0; i < unwanted.size(); ++i)
    if (unwanted[i]) removed.push_back(uint32_t(i));
  placement.Veto(gaussians, removed);
  std::fill(unwanted.begin(), unwanted.end(), 0);
  for (const uint32_t i : removed) unwanted[i] = 1;
  std::vector<uint32_t> remaining;
  for (size_t i = 0; i < unwanted.size(); ++i)
    if (!unwanted[i]) remaining.push_back(uint32_t(i));
  GatherAll(remaining, placement, gaussians, adam);
  statistics.Reset(gaussians.size());
  return report;
}

void SortInSpace(Placement& placement, Gaussians& gaussians, AdamState& adam) {
  std::vector<std::array<float, 3>> centers(gaussians.size());
  for (size_t i = 0; i < centers.size(); ++i) centers[i] = placement.Center(gaussians, i);
  GatherAll(MortonOrder(centers), placement, gaussians, adam);
}

void ResetOpacity(Gaussians& gaussians, AdamState& adam) {
  const float limit = std::log(kResetOpacity / (1 - kResetOpacity));
  for (float& logit : gaussians.values[kOpacityLogit]) logit = std::min(logit, limit);
  for (Gaussians* moments : {&adam.m, &adam.v})
    std::fill(moments->values[kOpacityLogit].begin(), moments->values[kOpacityLogit].end(), 0.0f);
}

}  // namespace cosplat
