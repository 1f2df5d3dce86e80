// Smaller kernels of a training step: the scale regulariser, sums of contributions, weights.
#pragma once

#include "splat/device/buffer.h"
#include "splat/device/sum.h"
#include "splat/gaussians.h"
#include "splat/render/contribution.h"

namespace cosplat {

struct AddContributions {
  View<const Contribution> more;
  View<Contribution> sums;
  COSPLAT_HD void operator()(size_t i) const { sums[i] += more[i]; }
};

struct Weaken {
  float factor;
  View<float> numbers;
  COSPLAT_HD void operator()(size_t i) const { numbers[i] *= factor; }
};

// Adds the gradient of weight / 2 times the sum of w_k c_k^2 over the coefficients of visible
// Gaussians, with w_k of CurvatureWeight (splat/basis_constants.h).
struct ColorCurvatureBackward {
  float weights[3 * CoefficientCount(kMaxTrainedDegree)];  // [width] weight w_k of each channel
  View<const float> visible;                               // [N] positive if so
  View<const float> rest;                                  // [N, width] bands >= 1
  View<float> d_rest;
  size_t width;
  COSPLAT_HD void operator()(size_t i) const {
    if (!(visible[i] > 0)) return;
    const float* coefficient = &rest[i * width];
    float* gradient = &d_rest[i * width];
    for (size_t k = 0; k < width; ++k) gradient[k] += weights[k] * coefficient[k];
  }
};

// Which Gaussians ScaleRegularizer (splat/train/step/train_settings.h) acts on: large needle-like
// (high-anisotropy) ones.
struct NeedleRule {
  float limit_log, ratio_log;
  // The longest axis; -1 if the Gaussian is not a needle.
  COSPLAT_HD int AxisOf(const float* s) const {
    int longest = 0, shortest = 0;
    for (int k = 1; k < 3; ++k) {
      if (s[longest] < s[k]) longest = k;
      if (s[k] < s[shortest]) shortest = k;
    }
    return s[longest] <= limit_log || s[longest] - s[shortest] <= ratio_log ? -1 : longest;
  }
};

// Lengths and number of needles: of one Gaussian, or summed (splat/device/sum.h).
struct NeedleSum {
  double length = 0, count = 0;
  COSPLAT_HD NeedleSum& operator+=(const NeedleSum& more) {
    length += more.length;
    count += more.count;
    return *this;
  }
};
struct NeedleLengths {
  NeedleRule rule;
  View<const float> scale_log;  // [N, 3]
  COSPLAT_HD size_t size() const { return scale_log.count / 3; }
  COSPLAT_HD NeedleSum operator[](size_t i) const {
    const int axis = rule.AxisOf(&scale_log[3 * i]);
    return axis < 0 ? NeedleSum{} : NeedleSum{std::exp(scale_log[3 * i + axis]), 1};
  }
};

struct NeedleTotal {
  double value = 0;  // the regulariser's term of the loss
  float scale = 0;   // weight / number of needles
};

// Runs as a single call.
struct AddUpNeedles {
  View<const NeedleSum> sums;  // of SumInTree
  float weight;
  NeedleTotal* total;
  COSPLAT_HD void operator()(size_t) const {
    const NeedleSum sum = SumOfBlock(sums, 0);
    const double scale = sum.count > 0 ? weight / sum.count : 0;
    *total = {sum.length * scale, float(scale)};
  }
};

// Adds the regulariser's gradient with respect to a needle's log length. `update_mask`: positive
// for the Gaussians that Adam updates, i.e. visible ones and needles.
struct NeedlesBackward {
  NeedleRule rule;
  View<const float> scale_log, radii;
  const NeedleTotal* total;
  View<float> d_scale_log, update_mask;
  COSPLAT_HD void operator()(size_t i) const {
    const float* s = &scale_log[3 * i];
    const int axis = rule.AxisOf(s);
    update_mask[i] = axis < 0 ? radii[i] : 1.0f;
    if (axis >= 0) d_scale_log[3 * i + axis] += total->scale * std::exp(s[axis]);
  }
};

}  // namespace cosplat
