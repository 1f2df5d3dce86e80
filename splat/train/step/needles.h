// The regulariser of large needle-like Gaussians (ScaleRegularizer,
// splat/train/step/train_settings.h).
#pragma once

#include "splat/device/buffer.h"
#include "splat/gaussians.h"
#include "splat/train/ranks/shards.h"
#include "splat/train/step/kernels/step.h"
#include "splat/train/step/train_settings.h"

namespace cosplat {

class NeedleRegularizer {
 public:
  NeedleRegularizer(const ScaleRegularizer& settings, Stream& stream)
      : settings_(settings), stream_(stream) {}

  bool acts() const { return settings_.weight != 0; }
  // Adds its gradient of this rank's Gaussians; returns which Gaussians Adam updates: visible ones,
  // and those that it acts on. visible: [own] positive if so. count: Gaussians of all ranks, which
  // all call it.
  View<const float> Backward(const Gaussians& gaussians,
                             View<const float> visible,
                             size_t count,
                             Shards& shards,
                             Gaussians& gradients);
  // [1] its term of the loss, in the stream's memory.
  const double* value() const { return &total_.data()->value; }
  void Release() { updated_ = {}; }
  size_t allocated_bytes() const { return AllocatedBytes(updated_); }  // bytes

 private:
  // The sums of all ranks, as SumInTree gives them.
  View<const NeedleSum> Sum(const NeedleLengths& own, size_t count, Shards& shards);

  const ScaleRegularizer& settings_;
  Stream& stream_;
  Buffer<NeedleSum> sums_, all_sums_;  // of SumInTree
  Buffer<NeedleTotal> total_;          // [1]
  Buffer<float> updated_;              // [own]
};

}  // namespace cosplat
