#include "splat/train/density/density.h"

#include <cmath>

#include "splat/base/error.h"
#include "splat/device/for_each.h"
#include "splat/device/gather.h"
#include "splat/train/density/kernels/control.h"
#include "splat/train/prune/mask_learner.h"
#include "splat/train/prune/pruner.h"
#include "splat/train/prune/rules.h"
#include "splat/train/ranks/shards.h"

namespace cosplat {
namespace {

// Maximum number of selections in a round of pruning, each replacing vetoed Gaussians by others.
constexpr int kChoices = 5;

void GatherGaussians(Gaussians& gaussians,
                     Gaussians& spare,
                     View<const uint32_t> source,
                     size_t first_zero,
                     Stream& stream) {
  Gaussians::ForEachArray(
      [&](const std::string&, size_t width, auto& array, auto& swap) {
        if (!array.empty()) GatherRows(array, swap, width, source, first_zero, stream);
      },
      gaussians,
      spare);
}

// Own coefficients of bands >= 1 and moments.
void HandOver(
    Shards& shards, const Reordering& order, Gaussians& own, AdamState& adam, Stream& stream) {
  std::vector<HandedOver> arrays{
      {&own.values[kColorRest], size_t(own.width(kColorRest)), order.source.count}};
  for (Gaussians* moments : {&adam.m, &adam.v})
    for (int a = 0; a < kAttributeCount; ++a)
      arrays.push_back({&moments->values[a], size_t(moments->width(a)), order.first_fresh});
  shards.Gather(order, arrays, stream);
}

void CheckCaughtUp(const AdamState& adam, const Stream& stream) {
  if (!stream.on_host()) return;
  for (const uint32_t step : adam.updated)
    if (step != adam.step) throw Error("density control", "deferred Adam updates are pending");
}

}  // namespace

math::RemovalRule RemovalRuleOf(const DensitySettings& settings, bool remove_oversized) {
  return {math::Logit(settings.min_opacity), remove_oversized, settings.max_scale};
}

void Population::Gather(const Reordering& order) const {
  CheckCaughtUp(adam, stream);
  const View<const uint32_t> source = order.source;
  const size_t n = source.count;
  GatherGaussians(gaussians, gradients, source, n, stream);
  if (shards) {
    HandOver(*shards, order, *own, adam, stream);
  } else {
    GatherGaussians(adam.m, gradients, source, order.first_fresh, stream);
    GatherGaussians(adam.v, gradients, source, order.first_fresh, stream);
  }
  DensityStatistics::ForEachArray(
      [&](const std::string&, size_t width, Buffer<float>& array) {
        GatherRows(
            array, gradients.values[kOpacityLogit], width, source, order.first_fresh, stream);
      },
      statistics);
  placement.Gather(source, stream);
  if (pruner && stream.on_host()) pruner->Gather(order);
  if (mask) mask->Gather(source, order.first_fresh, stream);
  if (!shards) gradients.RefillLike(gaussians, stream);
  adam.updated.Refill(AdamGroupCount(shards ? shards->share().CountOf(n) : n), stream);
  ForEach(adam.updated.size(), stream, FillNumbers{adam.updated.view(), adam.step});
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
    for (const uint32_t i : SelectForPruning({round.score,
                                              exempt,
                                              groups,
                                              round.remove,
                                              group_cap,
                                              group_floor,
                                              round.score_limit}))
      unwanted[i] = 1;
    const std::vector<uint8_t> chosen = unwanted;
    veto(unwanted);
    if (unwanted == chosen) break;
    for (size_t i = 0; i < count; ++i)
      if (chosen[i] != unwanted[i]) exempt[i] = 1;
  }
  return unwanted;
}

size_t DensityControl::PlacesOf(Buffer<uint64_t>& flags, Stream& stream) {
  stream.ExclusiveSum(flags);
  uint64_t count = 0;
  stream.Download(&count, flags.data() + flags.size() - 1, sizeof(count));
  stream.Wait();
  return count;
}

size_t DensityControl::Select(const DensitySettings& settings, const Population& population) {
  Stream& stream = population.stream;
  const size_t n = population.gaussians.size();
  mean_.Refill(n, stream);
  kind_.Refill(n, stream);
  kept_.Refill(n + 1, stream);
  ForEach(n + 1,
          stream,
          FindKinds{population.statistics.screen_gradient.view(),
                    population.statistics.visible.view(),
                    population.gaussians.values[kScaleLog].view(),
                    settings.gradient_threshold,
                    settings.cuts_long_axis ? -1.0f : settings.split_scale,
                    mean_.view(),
                    kind_.view(),
                    kept_.view()});
  return PlacesOf(kept_, stream);
}

void DensityControl::KeepStrongest(size_t room, Stream& stream) {
  const size_t n = kind_.size();
  order_.Refill(n, stream);
  ForEach(n,
          stream,
          StrengthKey{std::as_const(mean_).view(),
                      std::as_const(kind_).view(),
                      order_.keys.view(),
                      order_.values.view()});
  stream.Sort(order_, 32);
  if (room < n)
    ForEach(n - room, stream, LetStay{std::as_const(order_.values).view(), room, kind_.view()});
}

DensityReport DensityControl::AddChildren(bool cuts, const Population& population, Rng& rng) {
  Stream& stream = population.stream;
  const size_t n = population.gaussians.size();
  for (Buffer<uint64_t>* flags : {&kept_, &cloned_, &split_}) flags->Refill(n + 1, stream);
  const View<const uint8_t> kind = std::as_const(kind_).view();
  ForEach(n + 1, stream, FlagKinds{kind, kept_.view(), cloned_.view(), split_.view()});
  DensityReport report;
  const size_t kept = PlacesOf(kept_, stream);
  report.cloned = PlacesOf(cloned_, stream);
  report.split = PlacesOf(split_, stream);
  const size_t first_child = kept + report.cloned, children = 2 * report.split;
  source_.Refill(first_child + children, stream);
  ForEach(n,
          stream,
          PlaceSources{kind,
                       std::as_const(kept_).view(),
                       std::as_const(cloned_).view(),
                       std::as_const(split_).view(),
                       kept,
                       first_child,
                       source_.view()});
  population.Gather({std::as_const(source_).view(), kept});
  auto& values = population.gaussians.values;
  offsets_.Refill(3 * children, stream);
  const View<const float> rotation = std::as_const(values[kRotation]).view();
  if (cuts) {
    ForEach(children,
            stream,
            CutChild{first_child,
                     rotation,
                     offsets_.view(),
                     values[kScaleLog].view(),
                     values[kOpacityLogit].view()});
  } else {
    ForEach(children,
            stream,
            DrawChild{first_child,
                      rng,
                      std::log(math::kSplitShrink),
                      rotation,
                      offsets_.view(),
                      values[kScaleLog].view()});
    rng = rng.After(children * math::kSplitDraws);
  }
  population.placement.Move(
      std::as_const(offsets_).view(), first_child, population.gaussians, stream);
  return report;
}

DensityReport DensityControl::Control(const DensitySettings& settings,
                                      bool remove_oversized,
                                      const Population& population,
                                      Rng& rng) {
  Stream& stream = population.stream;
  const size_t before = population.gaussians.size();
  const size_t room = settings.max_count > before ? settings.max_count - before : 0;
  const bool held_back = Select(settings, population) > room;
  if (held_back) KeepStrongest(room, stream);
  if (settings.shares_opacity)
    ForEach(before,
            stream,
            ShareOpacity{std::as_const(kind_).view(),
                         population.gaussians.values[kOpacityLogit].view()});
  DensityReport report = AddChildren(settings.cuts_long_axis, population, rng);
  report.held_back = held_back;
  unwanted_.Refill(population.gaussians.size(), stream);
  ForEach(population.gaussians.size(),
          stream,
          MarkUnwanted{RemovalRuleOf(settings, remove_oversized),
                       ViewOf(population.gaussians),
                       unwanted_.view()});
  Remove(unwanted_.view(), population);
  return report;
}

size_t DensityControl::Remove(View<uint8_t> unwanted, const Population& population) {
  population.placement.Veto(population.gaussians, population.canvas, unwanted, population.stream);
  return RemoveMarked({unwanted.data, unwanted.count}, population);
}

size_t DensityControl::RemoveMarked(View<const uint8_t> unwanted, const Population& population) {
  Stream& stream = population.stream;
  const size_t n = population.gaussians.size();
  kept_.Refill(n + 1, stream);
  ForEach(n + 1, stream, FlagKept{unwanted, kept_.view()});
  const size_t kept = PlacesOf(kept_, stream);
  if (kept == n) return 0;
  source_.Refill(kept, stream);
  ForEach(n, stream, PlaceKept{unwanted, std::as_const(kept_).view(), source_.view()});
  population.Gather({std::as_const(source_).view(), kept});
  return n - kept;
}

size_t DensityControl::Prune(const PruneRound& round,
                             int group_cap,
                             int group_floor,
                             const Population& population) {
  Stream& stream = population.stream;
  const auto veto = [&](std::vector<uint8_t>& unwanted) {
    unwanted_.Upload(unwanted, stream);
    population.placement.Veto(population.gaussians, population.canvas, unwanted_.view(), stream);
    unwanted = unwanted_.Downloaded(stream);
  };
  const std::vector<uint8_t> unwanted = UnwantedBy(round,
                                                   population.gaussians.size(),
                                                   population.placement.Groups(stream),
                                                   group_cap,
                                                   group_floor,
                                                   veto);
  unwanted_.Upload(unwanted, stream);
  return RemoveMarked(std::as_const(unwanted_).view(), population);
}

void DensityControl::SortInSpace(const Population& population) {
  const View<const uint32_t> order = morton_.Order(
      population.placement.Centers(population.gaussians, population.stream), population.stream);
  population.Gather({order, order.count});
}

size_t DensityControl::allocated_bytes() const {
  return AllocatedBytes(mean_, kind_, unwanted_, kept_, cloned_, split_, source_, offsets_) +
         order_.allocated_bytes() + morton_.allocated_bytes();
}

float ResetOpacityLogit() { return math::Logit(math::kResetOpacity); }

void ResetOpacity(Gaussians& gaussians, AdamState& adam, Stream& stream) {
  Buffer<float>& logits = gaussians.values[kOpacityLogit];
  ForEach(logits.size(), stream, LowerTo{logits.view(), ResetOpacityLogit()});
  adam.m.values[kOpacityLogit].FillWithZeros(stream);
  adam.v.values[kOpacityLogit].FillWithZeros(stream);
}

}  // namespace cosplat
