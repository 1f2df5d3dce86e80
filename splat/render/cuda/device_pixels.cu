#include "splat/device/cuda/launch.cuh"
#include "splat/device/cuda/stream.h"
#include "splat/render/cuda/device_pixels.h"

namespace cosplat::cuda {
namespace {

template <AlphaMode kMode>
struct WritePixel {
  PicturePlanes planes;
  DeviceView<PixelBytes> pixels;
  __device__ void operator()(size_t p) const { pixels[p] = math::PixelAt<kMode>(planes, p); }
};

template <AlphaMode kMode>
void WritePixels(const DeviceImage& image, DeviceView<PixelBytes> pixels, cudaStream_t stream) {
  const PicturePlanes planes{image.color.data(), image.transmittance.data(), pixels.count};
  ForEach(pixels.count, stream, WritePixel<kMode>{planes, pixels});
}

}  // namespace

void DevicePixels::Write(const DeviceImage& image, AlphaMode alpha, cudaStream_t stream) {
  width_ = image.width;
  height_ = image.height;
  pixels_.Refill(image.transmittance.size());
  switch (alpha) {
    case AlphaMode::kStraight:
      return WritePixels<AlphaMode::kStraight>(image, pixels_.view(), stream);
    case AlphaMode::kPremultiplied:
      return WritePixels<AlphaMode::kPremultiplied>(image, pixels_.view(), stream);
    case AlphaMode::kOpaque:
      return WritePixels<AlphaMode::kOpaque>(image, pixels_.view(), stream);
  }
}

void DevicePixels::Download(Image8& out) const {
  out.width = width_;
  out.height = height_;
  out.channels = 4;
  out.data.resize(4 * out.pixels());
  const Stream stream;
  pixels_.Download(reinterpret_cast<PixelBytes*>(out.data.data()), stream.get());
  stream.Wait();
}

}  // namespace cosplat::cuda
