// splat/gaussians.h on the device: Gaussians, their gradients, Adam's moments.
#pragma once

#include <array>

#include "splat/device/cuda/memory.h"
#include "splat/gaussians.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat::cuda {

struct DeviceGaussians {
  int degree = 0;  // highest band stored
  DeviceBuffer<uint8_t> degrees;
  std::array<DeviceBuffer<float>, kAttributeCount> values;

  size_t size() const { return values[kOpacityLogit].size(); }
  int width(int attribute) const;  // floats per Gaussian

  void Upload(const Gaussians& gaussians, cudaStream_t stream);
  // The numbers, to Gaussians of the same count and degree.
  void Download(Gaussians& gaussians, cudaStream_t stream) const;
  // Room for the same layout; any values.
  void ResizeLike(const DeviceGaussians& other);
  void FillWithZeros(cudaStream_t stream);

  // As ViewOf and GradientViewOf (splat/render/rasterizer.h), pointers of the device.
  WorldGaussians View() const;
  WorldGradients GradientView(DeviceBuffer<float>& screen);
};

}  // namespace cosplat::cuda
