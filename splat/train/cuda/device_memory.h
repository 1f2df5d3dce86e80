// What fits into a device's memory: projected before Gaussians are added.
#pragma once

#include <string>

#include "splat/render/cuda/blend_backward.h"
#include "splat/render/cuda/device_gaussians.h"

namespace cosplat::cuda {

// Bytes that are free, as the driver says.
size_t FreeMemory();

// What training takes on the device.
struct Footprint {
  double per_gaussian = 0;  // bytes, of views too

  // Given what training holds for Gaussians already, and what is free beside it.
  size_t MostThatFit(size_t held, size_t free) const;
};

// With so many instances for each Gaussian in the fullest view.
Footprint FootprintOf(const DeviceGaussians& gaussians,
                      SumOrder order,
                      double instances_per_gaussian);

// Whether so many instances, drawn to be gone back from, fit into what the tape holds and what is
// free. The driver is asked only where the tape would have to grow.
bool HasCapacityFor(size_t instances, SumOrder order, const Tape& tape);

// One line for the user: that no more than these fit.
std::string NoticeOfMemory(size_t gaussians);

}  // namespace cosplat::cuda
