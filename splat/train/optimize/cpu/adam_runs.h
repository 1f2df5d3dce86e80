// The vectorised inner loop of splat/train/optimize/optimizer.cpp.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cosplat {

// One attribute of all Gaussians, and the constants of this step's update (math/adam.h).
struct AdamArray {
  float beta1 = 0, beta2 = 0, step_size = 0, scaled_eps = 0;
  size_t numbers = 0;
  int width = 1;                    // floats per Gaussian
  const float* gradient = nullptr;  // null: catch-up only
  float *value = nullptr, *m = nullptr, *v = nullptr;
  const float* rate_scale = nullptr;  // per-element factor on the learning rate; or null
};

// Gaussians [begin, end), all of them `behind` steps behind.
struct AdamRun {
  uint32_t begin, end;
  int behind;
};

// Updates the Gaussians of `count` runs. Returns the number of non-finite gradients (taken as
// zero).
size_t AdamRuns(const AdamArray& array, const AdamRun* runs, size_t count);

}  // namespace cosplat
