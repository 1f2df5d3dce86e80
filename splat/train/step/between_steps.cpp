// What StepEngine does between steps: density control, pruning, resets, and images of all
// Gaussians.
#include <algorithm>
#include <cstdio>
#include <utility>

#include "splat/base/error.h"
#include "splat/device/for_each.h"
#include "splat/train/density/bands.h"
#include "splat/train/ranks/kernels/shards.h"
#include "splat/train/step/step_engine.h"

namespace cosplat {
namespace {

constexpr double kGrowth = 1 + 1.0 / kHeadRoom;  // growth of a Buffer

// Bytes per Gaussian besides parameters, gradients and moments: three statistics and their swap
// memory, which of them move, of one view and of several, the screen gradient, and density control.
constexpr double kBesideParameters = 5 * sizeof(float) + 2 * sizeof(float) + 4 * sizeof(uint64_t) +
                                     6 * sizeof(uint32_t) + 2 * sizeof(uint8_t) + 4 * sizeof(float);

// Likewise, where ranks divide the Gaussians: what density control needs of all of them (position,
// rotation, scale, opacity, colour, smoothing), twice while they are reordered, and what is sent of
// a view.
constexpr double kOfOtherRanks =
    30 * sizeof(float) + 3 * (sizeof(ProjectedSplat) + sizeof(float)) + 2 * sizeof(SplatGradient);

std::string NoticeOfMemory(double free, size_t gaussians) {
  char text[160];
  std::snprintf(text,
                sizeof text,
                "GPU memory is nearly full (%.2f GB free): training continues with about %zu "
                "Gaussians",
                1e-9 * free,
                gaussians);
  return text;
}

}  // namespace

Population StepEngine::Everyone() {
  const TrainedState::Everyone all = state_.ForDensityControl();
  const bool divides = shards().divides();
  canvas_.emplace(Canvas{*device_.rasterizer, drawing_.image, *drawing_.tape});
  return {subject_,
          all.gaussians,
          all.own.adam,
          all.statistics,
          drawing_.gradients,
          stream_,
          &*canvas_,
          pruner_,
          mask_.learns() ? &mask_ : nullptr,
          divides ? &shards() : nullptr,
          divides ? &all.own.gaussians : nullptr};
}

// Releases what is sized by the number of Gaussians: it is not needed while they are copied and is
// allocated again afterwards, for the new number. On a device, where that waits, only what density
// control makes larger than steps need it, and what it needs the room of.
void StepEngine::ReleaseScratch() {
  if (!on_host()) {
    if (settings_.batch == 1 || FitsInOnePart()) return;
    drawing_.gradients = {};
    batch_.Release();
    return;
  }
  drawing_.gradients = {};
  drawing_.screen = {};
  needles_.Release();
  batch_.Release();
  shards().Release();
  density_.Release();
  drawing_.tape = device_.rasterizer->MakeTape();
}

StateView StepEngine::FetchForRanking() {
  const StateView view = state_.Read(Where::kHost, Extent::kGeometry);
  mask_.Download(stream_);
  return view;
}

Gaussians StepEngine::CaughtUp(const AdamSettings& rates) {
  Fetch();
  ReleaseScratch();
  const TrainingState& host = state_.host();
  const Buffer<uint32_t>& updated = host.adam.updated;
  const bool up_to_date = std::all_of(
      updated.begin(), updated.end(), [&](uint32_t step) { return step == host.adam.step; });
  if (up_to_date) return shards().AllOf(host.gaussians, count());  // as at the end of a run
  Gaussians gaussians = host.gaussians;
  {
    AdamState adam = host.adam;
    const View<const float> scale = subject_.PositionRateScale();
    Buffer<float> of_host(scale.count);
    if (!scale.empty()) stream_.Download(of_host.data(), scale.data, scale.count * sizeof(float));
    stream_.Wait();
    AdamCatchUpAll(rates, of_host, gaussians, adam);
  }
  return shards().divides() ? shards().AllOf(gaussians, count()) : std::move(gaussians);
}

void StepEngine::CatchUp(const AdamSettings& rates) {
  steps_.Settle(0);
  TrainingState& state = state_.Write();
  AdamCatchUpAll(rates, subject_.PositionRateScale(), state.gaussians, state.adam, stream_);
}

// Bytes per Gaussian where rankings or dropped bands assemble all attributes.
double StepEngine::OfWhole(size_t numbers) const {
  const bool assembles = settings_.prune.prunes() || settings_.drop_bands > 0;
  return state_.shards().divides() && assembles ? sizeof(float) * double(numbers) : 0;
}

bool StepEngine::FitsInOnePart() const {
  return settings_.batch > 1 && state_.now().gaussians.size() < kRowsPerPart;
}

size_t StepEngine::MaxThatFit() {
  if (on_host()) return size_t(-1);
  size_t numbers = 0;
  for (int a = 0; a < kAttributeCount; ++a) numbers += size_t(state_.now().gaussians.width(a));
  // Parameters, gradients (of one view or summed) and moments of the rank's share.
  const double ranks = double(shards().share().ranks), copies = FitsInOnePart() ? 5 : 4;
  const double per_gaussian = copies * sizeof(float) * double(numbers) / ranks + kBesideParameters +
                              (shards().divides() ? kOfOtherRanks : 0) + OfWhole(numbers) +
                              device_.rasterizer->BytesPerGaussian(instances_per_gaussian_) +
                              double(subject_.BytesPerGaussian());
  const double held = double(SumOf(Memory(), MemoryOf::kGaussians));
  const double max = (held + kUsableMemory * FreeMemory()) / (kGrowth * per_gaussian);
  return Smallest(uint32_t(std::min(max, double(UINT32_MAX))), *device_.ranks);
}

void StepEngine::ControlDensity(const DensitySettings& settings, bool remove_oversized) {
  DensitySettings limited = settings;
  limited.max_count = std::min(settings.max_count, MaxThatFit());
  ReleaseScratch();
  if (shards().divides()) {
    Gaussians& own = state_.Write().gaussians;
    ForEach(own.size(),
            stream_,
            SpoilBroken{std::as_const(own.values[kColorRest]).view(),
                        size_t(own.width(kColorRest)),
                        own.values[kColorDc].view()});
  }
  const DensityReport report =
      density_.Control(limited, remove_oversized, Everyone(), state_.host().rng);
  state_.ShareOut();
  instances_per_gaussian_ = 0;
  if (!report.held_back || limited.max_count == settings.max_count || memory_notice_.was_told)
    return;
  memory_notice_ = {NoticeOfMemory(FreeMemory(), count()), true};
}

size_t StepEngine::Prune(const PruneRound& round, int group_cap, int group_floor) {
  StoreMask();  // ranking may have started or ended mask learning
  const size_t removed = density_.Prune(round, group_cap, group_floor, Everyone());
  state_.ShareOut();
  state_.ReleaseRanked();
  return removed;
}

void StepEngine::SortInSpace() {
  density_.SortInSpace(Everyone());
  state_.ShareOut();
  ReleaseScratch();
}

void StepEngine::ResetStatistics() {
  TrainingState& state = state_.Write();
  state.statistics.Reset(state.gaussians.size(), stream_);
}

void StepEngine::ResetOpacity() {
  TrainingState& state = state_.Write();
  cosplat::ResetOpacity(state.gaussians, state.adam, stream_);
}

void StepEngine::UpdateSmoothing() {
  steps_.Settle(0);  // a step that is repeated must find the filter it had
  smoothing_.Find(subject_, state_.Write().gaussians, stream_);
}

double StepEngine::DropBands(float threshold,
                             View<const uint32_t> frames,
                             const std::array<float, 3>& background) {
  Fetch();
  TrainingState& host = state_.host();
  const auto zero_moments = [&host] {
    for (Gaussians* moments : {&host.adam.m, &host.adam.v})
      ZeroAbove(host.gaussians.degrees, *moments);
  };
  if (!shards().divides())
    return DropBandsInTraining(threshold, *this, frames, background, host.gaussians, [&] {
      zero_moments();
      Store();
    });
  Gaussians all;
  state_.Read(Where::kStream, Extent::kWhole).gaussians.Download(all, stream_);
  stream_.Wait();
  return DropBandsInTraining(threshold, *this, frames, background, all, [&] {
    host.gaussians.degrees.resize(host.gaussians.size());
    shards().TakeOwn(all.degrees, {0, count()}, host.gaussians.degrees);
    ZeroAbove(host.gaussians.degrees, host.gaussians);
    zero_moments();
    Store();
  });
}

std::vector<Contribution> StepEngine::Contributions(const FrameChoice& choice) {
  const Gaussians& shown = state_.Read(Where::kStream, Extent::kWhole).gaussians;
  Buffer<Contribution> of_image, sums;
  sums.Refill(count(), stream_);
  sums.FillWithZeros(stream_);
  for (size_t k = 0; k < choice.count(); ++k) {
    device_.rasterizer->Forward(subject_.ToWorld(shown, choice[k]),
                                shown.basis,
                                WithMargin(subject_.camera(choice[k]), choice.margin),
                                {choice.background, choice.degree},
                                drawing_.image,
                                *drawing_.tape);
    device_.rasterizer->Contributions(drawing_.image, *drawing_.tape, of_image);
    ForEach(count(), stream_, AddContributions{std::as_const(of_image).view(), sums.view()});
  }
  return sums.Downloaded(stream_);
}

ImageError StepEngine::ErrorIn(const FrameChoice& choice) {
  const Gaussians& shown = state_.Read(Where::kStream, Extent::kWhole).gaussians;
  return ErrorOfFrames(
      subject_, shown, choice, settings_.exposure, *device_.rasterizer, *drawing_.tape);
}

ImageError StepEngine::ErrorWithout(View<const uint8_t> removed, const FrameChoice& choice) {
  Gaussians rest;
  state_.Read(Where::kStream, Extent::kWhole).gaussians.Download(rest, stream_);
  stream_.Wait();
  Hide(removed, rest);
  return ErrorOf(rest, choice);
}

ImageError StepEngine::ErrorOf(const Gaussians& gaussians, const FrameChoice& choice) {
  Gaussians copy;
  if (!on_host()) copy.Upload(gaussians, stream_);
  return ErrorOfFrames(subject_,
                       on_host() ? gaussians : copy,
                       choice,
                       settings_.exposure,
                       *device_.rasterizer,
                       *drawing_.tape);
}

std::vector<MemoryPart> StepEngine::Memory() const {
  std::vector<MemoryPart> parts = state_.Memory();
  const auto add = [&](std::vector<MemoryPart> more) {
    for (MemoryPart& part : more) parts.push_back(std::move(part));
  };
  const RenderedImage& image = drawing_.image;
  add({{"gradients",
        AllocatedBytes(drawing_.gradients),
        settings_.batch == 1 || FitsInOnePart() ? MemoryOf::kGaussians : MemoryOf::kFixed},
       {"needles", needles_.allocated_bytes()},
       {"learned mask", mask_.allocated_bytes()},
       {"density control", density_.allocated_bytes()},
       {"screen gradients", AllocatedBytes(drawing_.screen)},
       {"reduction and sort scratch", stream_.allocated_bytes()},
       {"drawn image", AllocatedBytes(image.color, image.transmittance), MemoryOf::kPixels}});
  add(batch_.Memory());
  add(loss_.Memory());
  add(drawing_.tape->Memory());
  add(subject_.Memory());
  std::erase_if(parts, [](const MemoryPart& part) { return part.bytes == 0; });
  return parts;
}

}  // namespace cosplat
