// The vectorised inner loop of splat/optimizer.cpp.
#pragma once

#include <cstddef>

#include "splat/optimizer.h"

namespace cosplat {

// One attribute of all Gaussians, and the constants of this step's update (math/adam.h).
struct AdamArray {
  int width = 0;  // numbers per Gaussian
  float beta1 = 0, beta2 = 0, step_size = 0, scaled_eps = 0;
  const float* gradient = nullptr;
  float* value = nullptr;
  float* m = nullptr;
  float* v = nullptr;
  const float* rate_scale = nullptr;  // multiplies the step of each number; or null
};

// Updates the Gaussians of `count` ranges. Returns how many gradients were not finite (and counted
// as zero).
size_t AdamRanges(const AdamArray& array, const GaussianRange* ranges, size_t count);

}  // namespace cosplat
