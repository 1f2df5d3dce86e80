// The photometric loss and its gradient on the device: splat/train/loss.h there.
//
// picture, target image's bytes -> SSIM's partials -> dL/d(picture), in two passes of 16x16 pixels
// a block; sums are added in a fixed order.
#pragma once

#include <array>
#include <cstdint>

#include "splat/base/image.h"
#include "splat/device/cuda/memory.h"
#include "splat/train/loss.h"

namespace cosplat::cuda {

// A target image's bytes on the device.
struct DeviceTarget {
  int width = 0, height = 0, channels = 0;
  DeviceBuffer<uint8_t> bytes;  // [height, width, channels]

  // Room for it; any values.
  void ResizeLike(const Image8& image);
  void Upload(const Image8& image, cudaStream_t stream);
};

class PhotometricLoss {
 public:
  // As cosplat::PhotometricLoss::Evaluate; rendered, of the target's size, and d_rendered are the
  // device's. The loss stays there: see Value.
  void Evaluate(const LossWeights& weights,
                const float* rendered,
                const DeviceTarget& target,
                const std::array<float, 3>& background,
                DeviceBuffer<float>& d_rendered,
                cudaStream_t stream);
  // [1] the last loss, on the device.
  const double* value() const { return value_.data(); }
  // The same; the host waits for it.
  double Value(cudaStream_t stream) { return readback_.Get(value_.data(), stream); }

 private:
  DeviceBuffer<float> partials_;    // [channel, partial, height, width]
  DeviceBuffer<double> ssim_sums_;  // [blocks]
  DeviceBuffer<double> pointwise_sums_;
  DeviceBuffer<double> value_;
  Readback<double> readback_;
};

}  // namespace cosplat::cuda
