#include "splat/train/density.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splat/base/error.h"
#include "splat/prune/pruner.h"
#include "splat/prune/select.h"
#include "splat/render/rasterizer.h"
#include "splat/train/morton.h"

namespace cosplat {
namespace {

// How often a round of pruning chooses, with others in the place of those that must stay.
constexpr int kChoices = 4;

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
    mean[i] = math::MeanWhereVisible(statistics.screen_gradient[i], statistics.visible[i]);
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

// Which of the Gaussians after cloning and splitting go, by opacity, size and broken numbers.
std::vector<uint8_t> MarkUnwanted(const DensitySettings& settings,
                                  bool remove_oversized,
                                  const Gaussians& gaussians,
                                  DensityReport& report) {
  const math::RemovalRule rule = RemovalRuleOf(settings, remove_oversized);
  std::vector<uint8_t> unwanted(gaussians.size(), 0);
  for (size_t i = 0; i < gaussians.size(); ++i) {
    const bool broken = !AllFinite(gaussians, i);
    const math::Removal removal =
        RemovalOf(rule, gaussians.at(kOpacityLogit, i)[0], gaussians.at(kScaleLog, i));
    unwanted[i] = broken || removal != math::Removal::kNone;
    report.broken += broken;
    report.transparent += !broken && removal == math::Removal::kTransparent;
    report.oversized += !broken && removal == math::Removal::kOversized;
  }
  return unwanted;
}

// Puts those of `unwanted` that the placement keeps back to 0.
void HeedVeto(Placement& placement, const Gaussians& gaussians, std::vector<uint8_t>& unwanted) {
  std::vector<uint32_t> removed;
  for (size_t i = 0; i < unwanted.size(); ++i)
    if (unwanted[i]) removed.push_back(uint32_t(i));
  if (removed.empty()) return;
  placement.Veto(gaussians, removed);
  std::fill(unwanted.begin(), unwanted.end(), 0);
  for (const uint32_t i : removed) unwanted[i] = 1;
}

}  // namespace

math::RemovalRule RemovalRuleOf(const DensitySettings& settings, bool remove_oversized) {
  const float min_logit = std::log(settings.min_opacity / (1 - settings.min_opacity));
  return {min_logit, remove_oversized, settings.max_scale};
}

void DensityStatistics::Reset(size_t n) {
  for (Buffer<float>* b : {&screen_gradient, &plasticity, &visible}) *b = Buffer<float>(n, 0.0f);
}

void DensityStatistics::Gather(const Reordering& order) {
  for (Buffer<float>* b : {&screen_gradient, &plasticity, &visible}) {
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
      if (!(radii[i] > 0)) continue;
      const math::ShapeOfStep step =
          math::ShapeOf(&screen[2 * i], &d_scale_log[3 * i], &scale_log[3 * i], width, height);
      if (!step.IsUsable()) continue;
      screen_gradient[i] += step.screen;
      plasticity[i] += step.plasticity;
      visible[i] += 1;
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
    if (step != adam.step) throw Error("density control", "Adam has not caught up");
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

size_t Population::Take(const std::vector<uint8_t>& unwanted) const {
  Reordering remaining;
  for (uint32_t i = 0; i < gaussians.size(); ++i)
    if (!unwanted[i]) remaining.source.push_back(i);
  const size_t removed = gaussians.size() - remaining.source.size();
  if (removed > 0) Gather(remaining);
  return removed;
}

size_t Population::Remove(std::vector<uint8_t> unwanted) const {
  HeedVeto(placement, gaussians, unwanted);
  return Take(unwanted);
}

std::vector<uint8_t> UnwantedBy(const PruneRound& round,
                                size_t count,
                                const std::vector<int32_t>& groups,
                                int group_cap,
                                int group_floor,
                                const Veto& veto) {
  std::vector<uint8_t> exempt = round.exempt;
  exempt.resize(count, 0);
  std::vector<uint8_t> unwanted;
  for (int choice = 0; choice < kChoices; ++choice) {
    unwanted.assign(count, 0);
    for (const uint32_t i :
         SelectForPruning({round.score, exempt, groups, round.remove, group_cap, group_floor}))
      unwanted[i] = 1;
    const std::vector<uint8_t> chosen = unwanted;
    veto(unwanted);
    if (unwanted == chosen) break;
    for (size_t i = 0; i < count; ++i)
      if (chosen[i] != unwanted[i]) exempt[i] = 1;
  }
  return unwanted;
}

size_t Population::Prune(const PruneRound& round, int group_cap, int group_floor) const {
  return Take(UnwantedBy(
      round,
      gaussians.size(),
      placement.Groups(),
      group_cap,
      group_floor,
      [&](std::vector<uint8_t>& unwanted) { HeedVeto(placement, gaussians, unwanted); }));
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
    const bool split = math::LargestScale(gaussians.at(kScaleLog, i)) > settings.split_scale;
    is_split[i] = split;
    (split ? splits : clones).push_back(i);
  }
  report.cloned = clones.size();
  report.split = splits.size();

  if (settings.shares_opacity)  // before the copies are made
    for (const uint32_t i : clones) {
      float& logit = gaussians.at(kOpacityLogit, i)[0];
      logit = math::SharedOpacityLogit(logit);
    }
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
    const math::Vec3<float> offset =
        math::SplitOffset(gaussians.at(kRotation, i), gaussians.at(kScaleLog, i), rng);
    population.placement.Move(gaussians, uint32_t(i), {offset.x, offset.y, offset.z});
    for (int k = 0; k < 3; ++k) gaussians.at(kScaleLog, i)[k] -= std::log(math::kSplitShrink);
  }
  population.Remove(MarkUnwanted(settings, remove_oversized, gaussians, report));
  return report;
}

void SortInSpace(const Population& population) {
  std::vector<std::array<float, 3>> centers(population.gaussians.size());
  for (size_t i = 0; i < centers.size(); ++i)
    centers[i] = population.placement.Center(population.gaussians, i);
  population.Gather({MortonOrder(centers), {}});
}

float ResetOpacityLogit() { return std::log(math::kResetOpacity / (1 - math::kResetOpacity)); }

void ResetOpacity(Gaussians& gaussians, AdamState& adam) {
  const float limit = ResetOpacityLogit();
  for (float& logit : gaussians.values[kOpacityLogit]) logit = std::min(logit, limit);
  for (Gaussians* moments : {&adam.m, &adam.v})
    std::fill(moments->values[kOpacityLogit].begin(), moments->values[kOpacityLogit].end(), 0.0f);
}

}  // namespace cosplat
