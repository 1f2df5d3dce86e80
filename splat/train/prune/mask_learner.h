// Learns a pruning rule's mask in every step (splat/train/prune/learned_mask.h), on the host or a
// device.
//
// BeforeDraw: replaces the Gaussians' opacities by masked ones for rendering -> ... ->
// AfterBackward: gradients with respect to the mask and, through it, to the opacities; one step of
// the mask's Adam.
#pragma once

#include "splat/base/rng.h"
#include "splat/gaussians.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/prune/learned_mask.h"

namespace cosplat {

class MaskLearner {
 public:
  // Takes over a rule's mask, or none.
  void Upload(const MaskInSteps& mask, Stream& stream);
  // Copies what was learned back to the rule's mask. The host waits.
  void Download(Stream& stream);
  bool learns() const { return mask_.learned != nullptr; }
  // Number of random numbers that a step takes from the run's generator.
  uint64_t DrawsOf(size_t gaussians) const;

  // Sets the opacities that `world` is rendered with. rng: the run's generator before those draws.
  void BeforeDraw(const Gaussians& gaussians, Rng rng, WorldGaussians& world, Stream& stream);
  // If *overflowed is not 0, learns nothing but still counts the step.
  void AfterBackward(const Gaussians& gaussians,
                     View<const float> radii,
                     const uint32_t* overflowed,
                     Gaussians& gradients,
                     Stream& stream);
  // Takes back the count of steps that had no effect.
  void TakeBack(int64_t steps) { now_.step -= steps; }
  // [1] the mask's term of the loss, in the stream's memory.
  const double* value() const { return value_.data(); }

  // New Gaussians inherit their parent's mask value and have no momentum.
  void Gather(View<const uint32_t> source, size_t first_fresh, Stream& stream);
  size_t allocated_bytes() const;  // bytes

 private:
  MaskInSteps mask_;                     // the rule's mask
  LearnedMask now_{0, 0, 0};             // in the stream's memory
  Buffer<float> importance_;             // [N]
  Buffer<float> shown_, opacity_logit_;  // [N] this step: masks in the loss; rendered opacities
  Buffer<float> spare_;
  Buffer<double> sums_, value_;
};

}  // namespace cosplat
