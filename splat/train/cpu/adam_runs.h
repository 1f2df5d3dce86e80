// The vectorised inner loop of splat/train/optimizer.cpp.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cosplat {

// One attribute of all Gaussians, and the constants of this step's update (math/adam.h).
struct AdamArray {
  int width = 0;  // numbers per Gaussian
  float beta1 = 0, beta2 = 0, step_size = 0, scaled_eps = 0;
  const float* gradient = nullptr;  // null: nothing but what was put off
  float* value = nullptr;
  float* m = nullptr;
  float* v = nullptr;
  const float* rate_scale = nullptr;  // multiplies the step of each number; or null
};

// Gaussians [begin, end), which are that many steps behind.
struct AdamRun {
  uint32_t begin, end;
  int behind;
};

// Updates the Gaussians of `count` runs. Returns how many gradients were not finite (and counted as
// zero).
size_t AdamRuns(const AdamArray& array, const AdamRun* runs, size_t count);

}  // namespace cosplat
