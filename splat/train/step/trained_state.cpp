#include "splat/train/step/trained_state.h"

#include <utility>

#include "splat/device/arrays.h"

namespace cosplat {

TrainedState::TrainedState(TrainingState& host, Ranks& ranks, Stream& stream)
    : host_(host),
      stream_(stream),
      now_(stream.on_host() ? &host_ : &on_device_),
      shards_(ranks),
      ranks_(ranks),
      all_(shards_, stream) {
  if (shards_.divides()) {
    host_.gaussians = shards_.OwnOf(host_.gaussians);
    host_.statistics.Reset(host_.gaussians.size());
  }
  if (host_.adam.updated.empty()) host_.adam = AdamState(host_.gaussians);
}

TrainingState& TrainedState::Write() {
  all_.Release();
  ++version_;
  return *now_;
}

StateView TrainedState::Read(Where where, Extent extent) {
  if (extent != Extent::kOwn && shards_.divides())
    all_.Assemble(extent, now_->gaussians, now_->statistics, count());
  if (where == Where::kHost && !on_host() && extent == Extent::kGeometry) return GeometryOnHost();
  if (where == Where::kHost && !on_host() && on_host_ != version_) {
    on_device_.gaussians.Download(host_.gaussians, stream_);
    on_device_.adam.Download(host_.adam, stream_);
    DownloadArrays(on_device_.statistics, host_.statistics, stream_);
    DownloadArrays(on_device_.exposures, host_.exposures, stream_);
    stream_.Wait();
    on_host_ = version_;
  }
  if (extent != Extent::kOwn && shards_.divides()) return {all_.gaussians(), all_.statistics()};
  const TrainingState& state = where == Where::kHost ? host_ : *now_;
  return {state.gaussians, state.statistics};
}

// One rank's geometry goes into the state's own copy, which stays out of date.
StateView TrainedState::GeometryOnHost() {
  const bool divides = shards_.divides();
  const Gaussians& from = divides ? all_.gaussians() : now_->gaussians;
  Gaussians& to = divides ? ranked_ : host_.gaussians;
  DensityStatistics& statistics = divides ? ranked_statistics_ : host_.statistics;
  if (divides) {
    to.degree = from.degree;
    to.basis = from.basis;
    to.antialiased = from.antialiased;
  }
  to.Resize(count());
  for (int a = 0; a < kAttributeCount; ++a)
    if (a != kColorRest && a != kCorrection) from.values[a].Download(to.values[a], stream_);
  from.degrees.Download(to.degrees, stream_);
  from.smoothing.Download(to.smoothing, stream_);
  DownloadArrays(divides ? all_.statistics() : now_->statistics, statistics, stream_);
  stream_.Wait();
  return {to, statistics};
}

TrainedState::Everyone TrainedState::ForDensityControl() {
  if (!shards_.divides()) {
    Write();
    return {now_->gaussians, now_->statistics, *now_};
  }
  Read(Where::kStream, Extent::kGeometry);
  all_.ForgetBands();
  return {all_.gaussians(), all_.statistics(), *now_};
}

void TrainedState::ShareOut() {
  count_ = shards_.divides() ? all_.gaussians().size() : now_->gaussians.size();
  if (shards_.divides()) all_.ShareOut(now_->gaussians, now_->statistics);
  ++version_;
}

void TrainedState::Store() {
  all_.Release();
  if (!on_host()) {
    on_device_.gaussians.Upload(host_.gaussians, stream_);
    on_device_.adam.Upload(host_.adam, stream_);
    UploadArrays(host_.statistics, on_device_.statistics, stream_);
    UploadArrays(host_.exposures, on_device_.exposures, stream_);
    stream_.Wait();  // the copies read the state's memory
  }
  on_host_ = ++version_;
  count_ = size_t(Sum(now_->gaussians.size(), ranks_));
}

void TrainedState::ReleaseRanked() {
  ranked_ = {};
  ranked_statistics_ = {};
}

std::vector<MemoryPart> TrainedState::Memory() const {
  const AdamState& adam = now_->adam;
  return {
      {"parameters", AllocatedBytes(now_->gaussians)},
      {"messages between ranks", shards_.MessageBytes(), MemoryOf::kFixed},
      {"Gaussians of all ranks", AllocatedBytes(all_.gaussians())},
      {"first moments", AllocatedBytes(adam.m)},
      {"second moments", AllocatedBytes(adam.v)},
      {"Adam group state", AllocatedBytes(adam.updated, adam.behind)},
      {"density statistics", AllocatedByArrays(now_->statistics)},
  };
}

}  // namespace cosplat
