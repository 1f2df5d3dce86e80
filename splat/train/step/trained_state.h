// The state of a run where it is trained, and its copies elsewhere: in host memory, and of all
// ranks.
//
//   Write -> the trained state, whose copies are then out of date
//   Read(where, extent) -> a copy that is up to date, made if there is none
#pragma once

#include <cstdint>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/train/ranks/all_gaussians.h"
#include "splat/train/ranks/shards.h"
#include "splat/train/state/training_state.h"

namespace cosplat {

enum class Where { kHost, kStream };

struct StateView {
  const Gaussians& gaussians;
  const DensityStatistics& statistics;
};

class TrainedState {
 public:
  // host: the state in host memory. Trained there or, on a device, in the memory of `stream`. All
  // three must outlive this.
  TrainedState(TrainingState& host, Ranks& ranks, Stream& stream);

  bool on_host() const { return now_ == &host_; }
  // As it is trained, of this rank.
  const TrainingState& now() const { return *now_; }
  // The same, to be changed.
  TrainingState& Write();
  // What is not copied: iteration, random numbers, frames.
  TrainingState& host() { return host_; }

  // kOwn: with all else of the state. Valid until the next call or change. On the host kGeometry is
  // of arrays that have been copied for this (bands are out of date), kWhole is not to be had
  // there. All ranks call it for more than kOwn.
  StateView Read(Where where, Extent extent);
  // For density control, which reorders all of it: geometry of all ranks and, of this rank alone,
  // the state. ShareOut afterwards, before anything else.
  struct Everyone {
    Gaussians& gaussians;
    DensityStatistics& statistics;
    TrainingState& own;
  };
  Everyone ForDensityControl();
  void ShareOut();
  // Takes over host memory that was changed. All ranks call it.
  void Store();

  size_t count() const { return count_; }  // Gaussians of all ranks
  Shards& shards() { return shards_; }
  const Shards& shards() const { return shards_; }
  uint64_t assembled() const { return all_.assembled(); }
  // Copies for rankings are not needed before the next one.
  void ReleaseRanked();
  std::vector<MemoryPart> Memory() const;

 private:
  StateView GeometryOnHost();

  TrainingState& host_;
  Stream& stream_;
  TrainingState on_device_;
  TrainingState* now_;
  Shards shards_;
  Ranks& ranks_;
  AllGaussians all_;                     // empty where it is out of date
  Gaussians ranked_;                     // of all ranks, on the host, trained on a device
  DensityStatistics ranked_statistics_;  // likewise
  uint64_t version_ = 0, on_host_ = 0;   // of what is trained, and of its copy
  size_t count_ = 0;
};

}  // namespace cosplat
