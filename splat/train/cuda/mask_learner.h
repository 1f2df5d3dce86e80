// The mask that a rule of pruning learns in every step (splat/prune/learned_mask.h), on the device.
//
// BeforeDraw: what is drawn is not the Gaussians' own opacities -> ... -> AfterBackward: gradients
// by the mask and, through it, by the opacities; one step of the mask's Adam.
#pragma once

#include "splat/base/rng.h"
#include "splat/prune/learned_mask.h"
#include "splat/render/cuda/device_gaussians.h"

namespace cosplat::cuda {

class MaskLearner {
 public:
  // Takes over a rule's mask, or none.
  void Upload(const MaskInSteps& mask, cudaStream_t stream);
  // Brings what was learned back to where it came from. The host waits.
  void Download(cudaStream_t stream);
  bool learns() const { return mask_.learned != nullptr; }
  // Random numbers that a step takes of the run's.
  uint64_t DrawsOf(size_t gaussians) const;

  // Sets what `world` is drawn with. rng: the run's, before those draws.
  void BeforeDraw(const DeviceGaussians& gaussians,
                  Rng rng,
                  WorldGaussians& world,
                  cudaStream_t stream);
  // Learns nothing where *overflowed is not 0, but counts the step.
  void AfterBackward(const DeviceGaussians& gaussians,
                     DeviceView<const float> radii,
                     const uint32_t* overflowed,
                     DeviceGaussians& gradients,
                     cudaStream_t stream);
  // So many steps were in vain.
  void TakeBack(int64_t steps) { step_ -= steps; }
  // [1] what it adds to the loss, on the device.
  const double* value() const { return value_.data(); }

  // As LearnedMask::Gather.
  void Gather(DeviceView<const uint32_t> source, size_t first_fresh, cudaStream_t stream);
  size_t held() const;  // bytes

 private:
  MaskInSteps mask_;  // where it came from
  int64_t step_ = 0;
  DeviceBuffer<float> mu_, m_, v_, importance_;  // [N]
  DeviceBuffer<float> shown_, opacity_logit_;    // [N] of this step: of the loss; as drawn
  DeviceBuffer<float> spare_;
  DeviceBuffer<double> sums_, value_;
};

}  // namespace cosplat::cuda
