// The gradients of a step of several views, summed in the order of the views.
//
//   Begin -> Add, for each part of the Gaussians once per view -> gradients, moves -> Adam
#pragma once

#include "splat/gaussians.h"
#include "splat/train/state/density_statistics.h"

namespace cosplat {

// Gradients of one view for a part of the Gaussians, in the stream's memory.
struct ViewGradients {
  Gaussians& gradients;       // valid in groups (kGaussianGroup) with a visible Gaussian
  View<const float> screen;   // [part, 2] as in WorldGradients
  View<const float> radii;    // [part] 0: not visible
  int width = 0, height = 0;  // px, of the image
};

class GradientSum {
 public:
  // In the memory of `stream`, on which everything runs.
  explicit GradientSum(Stream& stream) : stream_(stream) {}

  // views: of the step, whose mean is taken.
  void Begin(const Gaussians& gaussians, size_t views);
  // first: Gaussian that the part begins with, a multiple of kGaussianGroup. Of one part, views are
  // added in their order. statistics: null if they are not gathered.
  void Add(const ViewGradients& view,
           size_t first,
           const Gaussians& gaussians,
           DensityStatistics* statistics);

  // Mean over the views, in the groups that `update_mask` names; elsewhere any values.
  Gaussians& gradients() { return sum_; }
  // [N] positive for Gaussians that are visible in a view.
  const Buffer<float>& update_mask() const { return update_mask_; }
  // Sets the gradients of groups without a visible Gaussian to 0, for those who move them too.
  void ZeroUnseen();

  // Groups with a Gaussian that is visible in a view.
  size_t CountSeen() const;

  void Release();
  size_t allocated_bytes() const {
    return AllocatedBytes(sum_) + AllocatedBytes(update_mask_, seen_);
  }  // bytes

 private:
  Stream& stream_;
  Gaussians sum_;
  Buffer<float> update_mask_;
  Buffer<uint8_t> seen_;    // [groups] whether `sum_` is set
  float of_view_ = 1;       // one over the number of views
  Buffer<uint32_t> never_;  // [1] 0: no step of several views overflows
};

}  // namespace cosplat
