// Memory held by a training run, as reported by itself and as measured by the system.
#pragma once

#include <vector>

#include "apps/study/bench/synthetic_view.h"
#include "splat/device/buffer.h"

namespace cosplat {

// After `steps` training steps on the view, at its full degree, without density control.
std::vector<MemoryPart> MemoryOfSteps(SyntheticView view, int steps);

// Growth of the process's resident set per additional Gaussian, bytes: a training run of `more`
// Gaussians compared with one of `fewer`, both on synthetic views of side x side px (so image
// buffers cancel out). Reads Linux's /proc; throws Error where that is not available.
double ResidentBytesPerGaussian(size_t fewer, size_t more, int side);

}  // namespace cosplat
