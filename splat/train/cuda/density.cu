#include <cmath>

#include "splat/device/cuda/launch.cuh"
#include "splat/device/memory_part.h"
#include "splat/train/cuda/density.h"

namespace cosplat::cuda {
namespace {

enum Kind : uint8_t { kStays, kIsCloned, kIsSplit };

// What happens to each, and flags of who is chosen.
struct FindKinds {
  DeviceView<const float> screen_gradient, visible, scale_log;
  float threshold, split_scale;
  DeviceView<float> mean;
  DeviceView<uint8_t> kind;
  DeviceView<uint64_t> chosen;  // one more than Gaussians
  __device__ void operator()(size_t i) const {
    chosen[i] = 0;
    if (i == mean.count) return;
    mean[i] = math::MeanWhereVisible(screen_gradient[i], visible[i]);
    kind[i] = kStays;
    if (!(mean[i] >= threshold)) return;
    chosen[i] = 1;
    kind[i] = math::LargestScale(&scale_log[3 * i]) > split_scale ? kIsSplit : kIsCloned;
  }
};

// Strongest first, then those that are not chosen. Means are not negative: their bits order as
// values.
struct StrengthKey {
  DeviceView<const float> mean;
  DeviceView<const uint8_t> kind;
  DeviceView<uint32_t> keys, gaussians;
  __device__ void operator()(size_t i) const {
    keys[i] = kind[i] == kStays ? 0xffffffffu : 0x7fffffffu - BitsOf(mean[i]);
    gaussians[i] = uint32_t(i);
  }
};

struct LetStay {
  DeviceView<const uint32_t> gaussians;
  size_t from;
  DeviceView<uint8_t> kind;
  __device__ void operator()(size_t k) const { kind[gaussians[from + k]] = kStays; }
};

// Before the copies are made.
struct ShareOpacity {
  DeviceView<const uint8_t> kind;
  DeviceView<float> opacity_logit;
  __device__ void operator()(size_t i) const {
    if (kind[i] == kIsCloned) opacity_logit[i] = math::SharedOpacityLogit(opacity_logit[i]);
  }
};

struct FlagKinds {
  DeviceView<const uint8_t> kind;
  DeviceView<uint64_t> kept, cloned, split;
  __device__ void operator()(size_t i) const {
    const bool one = i < kind.count;
    kept[i] = one && kind[i] != kIsSplit;
    cloned[i] = one && kind[i] == kIsCloned;
    split[i] = one && kind[i] == kIsSplit;
  }
};

// Those that are kept, then clones, then two children of each that is split.
struct PlaceSources {
  DeviceView<const uint8_t> kind;
  DeviceView<const uint64_t> kept, cloned, split;
  size_t first_clone, first_child;
  DeviceView<uint32_t> source;
  __device__ void operator()(size_t i) const {
    const uint32_t me = uint32_t(i);
    if (kind[i] != kIsSplit) source[kept[i]] = me;
    if (kind[i] == kIsCloned) source[first_clone + cloned[i]] = me;
    if (kind[i] == kIsSplit)
      for (int k = 0; k < 2; ++k) source[first_child + 2 * split[i] + k] = me;
  }
};

// Where each child goes, from its parent's place, which it has; and its scale.
struct DrawChild {
  size_t first;
  Rng rng;  // before the first child
  float shrink_log;
  DeviceView<const float> rotation;
  DeviceView<float> offsets, scale_log;
  __device__ void operator()(size_t c) const {
    const size_t i = first + c;
    Rng mine = rng.After(c * math::kSplitDraws);
    const math::Vec3<float> offset = math::SplitOffset(&rotation[4 * i], &scale_log[3 * i], mine);
    offsets[3 * c] = offset.x;
    offsets[3 * c + 1] = offset.y;
    offsets[3 * c + 2] = offset.z;
    for (int k = 0; k < 3; ++k) scale_log[3 * i + k] -= shrink_log;
  }
};

struct MarkUnwanted {
  math::RemovalRule rule;
  WorldGaussians gaussians;
  DeviceView<uint8_t> unwanted;
  __device__ static bool AllFinite(const float* row, int width) {
    for (int k = 0; k < width; ++k)
      if (!std::isfinite(row[k])) return false;
    return true;
  }
  __device__ void operator()(size_t i) const {
    const WorldGaussians& g = gaussians;
    const bool whole = AllFinite(g.position + 3 * i, 3) && AllFinite(g.rotation + 4 * i, 4) &&
                       AllFinite(g.scale_log + 3 * i, 3) && AllFinite(g.opacity_logit + i, 1) &&
                       AllFinite(g.color_dc + 3 * i, 3) &&
                       AllFinite(g.color_rest + g.rest_width * i, g.rest_width);
    unwanted[i] =
        !whole || RemovalOf(rule, g.opacity_logit[i], g.scale_log + 3 * i) != math::Removal::kNone;
  }
};

struct FlagKept {
  DeviceView<const uint8_t> unwanted;
  DeviceView<uint64_t> kept;
  __device__ void operator()(size_t i) const { kept[i] = i < unwanted.count && !unwanted[i]; }
};

struct PlaceKept {
  DeviceView<const uint8_t> unwanted;
  DeviceView<const uint64_t> kept;
  DeviceView<uint32_t> source;
  __device__ void operator()(size_t i) const {
    if (!unwanted[i]) source[kept[i]] = uint32_t(i);
  }
};

struct LowerTo {
  DeviceView<float> numbers;
  float limit;
  __device__ void operator()(size_t i) const {
    if (limit < numbers[i]) numbers[i] = limit;
  }
};

}  // namespace

size_t DensityControl::PlacesOf(DeviceBuffer<uint64_t>& flags, cudaStream_t stream) {
  sorter_.ExclusiveSum(flags, stream);
  return readback_.Get(flags.data() + flags.size() - 1, stream);
}

size_t DensityControl::Select(const DensitySettings& settings,
                              const Population& population,
                              cudaStream_t stream) {
  const size_t n = population.size();
  mean_.Refill(n);
  kind_.Refill(n);
  kept_.Refill(n + 1);
  ForEach(n + 1,
          stream,
          FindKinds{population.statistics.screen_gradient.view(),
                    population.statistics.visible.view(),
                    population.values.values[kScaleLog].view(),
                    settings.gradient_threshold,
                    settings.split_scale,
                    mean_.view(),
                    kind_.view(),
                    kept_.view()});
  return PlacesOf(kept_, stream);
}

void DensityControl::KeepStrongest(size_t room, cudaStream_t stream) {
  const size_t n = kind_.size();
  order_.Refill(n);
  ForEach(n,
          stream,
          StrengthKey{std::as_const(mean_).view(),
                      std::as_const(kind_).view(),
                      order_.keys.view(),
                      order_.values.view()});
  sorter_.Sort(order_, 32, stream);
  ForEach(n - room, stream, LetStay{std::as_const(order_.values).view(), room, kind_.view()});
}

void DensityControl::Gather(Population& population,
                            DeviceView<const uint32_t> source,
                            size_t first_fresh,
                            cudaStream_t stream) {
  population.Gather(source, first_fresh, stream);
  placement_.Gather(source, stream);
}

void DensityControl::AddChildren(Population& population, Rng& rng, cudaStream_t stream) {
  const size_t n = population.size();
  for (DeviceBuffer<uint64_t>* flags : {&kept_, &cloned_, &split_}) flags->Refill(n + 1);
  const DeviceView<const uint8_t> kind = std::as_const(kind_).view();
  ForEach(n + 1, stream, FlagKinds{kind, kept_.view(), cloned_.view(), split_.view()});
  const size_t kept = PlacesOf(kept_, stream);
  const size_t children = kept + PlacesOf(cloned_, stream);
  const size_t after = children + 2 * PlacesOf(split_, stream);
  source_.Refill(after);
  ForEach(n,
          stream,
          PlaceSources{kind,
                       std::as_const(kept_).view(),
                       std::as_const(cloned_).view(),
                       std::as_const(split_).view(),
                       kept,
                       children,
                       source_.view()});
  Gather(population, std::as_const(source_).view(), kept, stream);
  auto& values = population.values.values;
  offsets_.Refill(3 * (after - children));
  ForEach(after - children,
          stream,
          DrawChild{children,
                    rng,
                    std::log(math::kSplitShrink),
                    std::as_const(values[kRotation]).view(),
                    offsets_.view(),
                    values[kScaleLog].view()});
  placement_.Move(std::as_const(offsets_).view(), children, population.values, stream);
  rng = rng.After((after - children) * math::kSplitDraws);
}

bool DensityControl::Control(const DensitySettings& settings,
                             bool remove_oversized,
                             Population& population,
                             Rng& rng,
                             cudaStream_t stream) {
  const size_t before = population.size();
  const size_t room = settings.max_count > before ? settings.max_count - before : 0;
  const bool held_back = Select(settings, population, stream) > room;
  if (held_back) KeepStrongest(room, stream);
  if (settings.shares_opacity)
    ForEach(
        before,
        stream,
        ShareOpacity{std::as_const(kind_).view(), population.values.values[kOpacityLogit].view()});
  AddChildren(population, rng, stream);
  unwanted_.Refill(population.size());
  ForEach(
      population.size(),
      stream,
      MarkUnwanted{
          RemovalRuleOf(settings, remove_oversized), population.values.View(), unwanted_.view()});
  placement_.Veto(population.values, canvas_, unwanted_.view());
  Take(std::as_const(unwanted_).view(), population, stream);
  return held_back;
}

void DensityControl::Take(DeviceView<const uint8_t> unwanted,
                          Population& population,
                          cudaStream_t stream) {
  const size_t n = population.size();
  kept_.Refill(n + 1);
  ForEach(n + 1, stream, FlagKept{unwanted, kept_.view()});
  const size_t kept = PlacesOf(kept_, stream);
  if (kept == n) return;
  source_.Refill(kept);
  ForEach(n, stream, PlaceKept{unwanted, std::as_const(kept_).view(), source_.view()});
  Gather(population, std::as_const(source_).view(), kept, stream);
}

size_t DensityControl::held() const {
  return HeldBy(
             mean_, kind_, unwanted_, kept_, cloned_, split_, source_, offsets_, codes_, boxes_) +
         order_.held() + sorter_.held();
}

void ResetOpacity(Population& population, cudaStream_t stream) {
  DeviceBuffer<float>& logits = population.values.values[kOpacityLogit];
  ForEach(logits.size(), stream, LowerTo{logits.view(), ResetOpacityLogit()});
  population.adam.m.values[kOpacityLogit].FillWithZeros(stream);
  population.adam.v.values[kOpacityLogit].FillWithZeros(stream);
}

}  // namespace cosplat::cuda
