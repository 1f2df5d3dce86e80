// splat/render/device_picture.h on a CUDA device.
#pragma once

#include "splat/device/cuda/memory.h"
#include "splat/render/cuda/tape.h"
#include "splat/render/device_picture.h"
#include "splat/render/kernels/pixel_bytes.h"

namespace cosplat::cuda {

class DevicePixels : public DevicePicture {
 public:
  // The picture's floats as bytes; they are there when the stream has been waited for.
  void Write(const DeviceImage& image, AlphaMode alpha, cudaStream_t stream);

  int width() const override { return width_; }
  int height() const override { return height_; }
  void Download(Image8& out) const override;
  const PixelBytes* data() const { return pixels_.data(); }  // [height, width]

 private:
  int width_ = 0, height_ = 0;
  DeviceBuffer<PixelBytes> pixels_;
};

}  // namespace cosplat::cuda
