// The Gaussians of all ranks, where ranks divide them: for what looks at all of them, between
// steps.
//
//   Assemble -> density control, ranking, images -> ShareOut -> Release
#pragma once

#include "splat/gaussians.h"
#include "splat/train/ranks/shards.h"
#include "splat/train/state/density_statistics.h"

namespace cosplat {

// How much of the Gaussians, with their statistics, degrees and smoothing: this rank's; those of
// all ranks, without coefficients of bands >= 1; or all of those.
enum class Extent { kOwn, kGeometry, kWhole };

class AllGaussians {
 public:
  // In the memory of `stream`. Both must outlive this.
  AllGaussians(Shards& shards, Stream& stream) : shards_(shards), stream_(stream) {}

  // All ranks call these together; own: this rank's.

  // count: of all. Does nothing if as much is there.
  void Assemble(Extent extent, Gaussians& own, DensityStatistics& own_statistics, size_t count);
  // After they were changed and perhaps reordered: takes the share of this rank, without bands >=
  // 1, which were handed over already (Population::Gather).
  void ShareOut(Gaussians& own, DensityStatistics& own_statistics);
  // Leaves the geometry.
  void ForgetBands();
  void Release();

  Gaussians& gaussians() { return gaussians_; }
  const Gaussians& gaussians() const { return gaussians_; }
  DensityStatistics& statistics() { return statistics_; }
  // Numbers assembled since the start.
  uint64_t assembled() const { return assembled_; }

 private:
  Shards& shards_;
  Stream& stream_;
  Gaussians gaussians_;
  DensityStatistics statistics_;
  Extent extent_ = Extent::kOwn;  // kOwn: nothing is assembled
  uint64_t assembled_ = 0;
};

}  // namespace cosplat
