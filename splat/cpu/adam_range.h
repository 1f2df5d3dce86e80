// The vectorised inner loop of splat/optimizer.cpp.
#pragma once

#include <cstddef>

namespace cosplat {

struct AdamConstants {
  float beta1, beta2, step_size, scaled_eps;
};

// Updates n numbers; `rate_scale` [n] multiplies the step of each, or is null. Returns how many
// gradients were not finite (and counted as zero).
size_t AdamRange(const AdamConstants& constants,
                 size_t n,
                 const float* gradient,
                 float* value,
                 float* m,
                 float* v,
                 const float* rate_scale);

}  // namespace cosplat
