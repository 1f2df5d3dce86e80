// Learns the mask of a rule of pruning in every step (splat/prune/learned_mask.h), on the host or
// on a device.
//
// BeforeDraw: what is drawn is not the Gaussians' own opacities -> ... -> AfterBackward: gradients
// by the mask and, through it, by the opacities; one step of the mask's Adam.
#pragma once

#include "splat/base/rng.h"
#include "splat/gaussians.h"
#include "splat/prune/learned_mask.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat {

class MaskLearner {
 public:
  // Takes over a rule's mask, or none.
  void Upload(const MaskInSteps& mask, Stream& stream);
  // Brings what was learned back to where it came from. The host waits.
  void Download(Stream& stream);
  bool learns() const { return mask_.learned != nullptr; }
  // Random numbers that a step takes of the run's.
  uint64_t DrawsOf(size_t gaussians) const;

  // Sets what `world` is drawn with. rng: the run's, before those draws.
  void BeforeDraw(const Gaussians& gaussians, Rng rng, WorldGaussians& world, Stream& stream);
  // Learns nothing where *overflowed is not 0, but counts the step.
  void AfterBackward(const Gaussians& gaussians,
                     View<const float> radii,
                     const uint32_t* overflowed,
                     Gaussians& gradients,
                     Stream& stream);
  // So many steps were in vain.
  void TakeBack(int64_t steps) { step_ -= steps; }
  // [1] what it adds to the loss, in the stream's memory.
  const double* value() const { return value_.data(); }

  // New ones have their parent's number and no momentum.
  void Gather(View<const uint32_t> source, size_t first_fresh, Stream& stream);
  size_t held() const;  // bytes

 private:
  MaskInSteps mask_;  // where it came from
  int64_t step_ = 0;
  Buffer<float> mu_, m_, v_, importance_;  // [N]
  Buffer<float> shown_, opacity_logit_;    // [N] of this step: of the loss; as drawn
  Buffer<float> spare_;
  Buffer<double> sums_, value_;
};

}  // namespace cosplat
