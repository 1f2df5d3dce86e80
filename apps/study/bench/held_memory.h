// What a training run holds in memory, as it says itself and as the system sees it.
#pragma once

#include <vector>

#include "apps/study/bench/synthetic_view.h"
#include "splat/device/buffer.h"

namespace cosplat {

// Sum of the parts that grow with the Gaussians or with the pixels, bytes.
size_t SumOf(const std::vector<MemoryPart>& parts, MemoryOf of);

// After `steps` training steps on the view, at its full degree, without density control.
std::vector<MemoryPart> MemoryOfSteps(SyntheticView view, int steps);

// Bytes per Gaussian by which the process's resident set grows more with a training run of `more`
// Gaussians than with one of `fewer`, both on synthetic views of side x side px (whose buffers are
// therefore not in it). Read from Linux's /proc; throws Error where that is not.
double ResidentBytesPerGaussian(size_t fewer, size_t more, int side);

}  // namespace cosplat
