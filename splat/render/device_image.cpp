#include "splat/render/device_image.h"

#include <utility>

#include "splat/device/for_each.h"
#include "splat/render/image_renderer.h"

namespace cosplat {

void DeviceImage::Write(const RenderedImage& image, AlphaMode alpha, Stream& stream) {
  width_ = image.width;
  height_ = image.height;
  pixels_.Refill(image.transmittance.size(), stream);
  const ImagePlanes planes{image.color.data(), image.transmittance.data(), pixels_.size()};
  switch (alpha) {
    case AlphaMode::kStraight:
      return ForEach(
          planes.pixels, stream, WritePixel<AlphaMode::kStraight>{planes, pixels_.data()});
    case AlphaMode::kPremultiplied:
      return ForEach(
          planes.pixels, stream, WritePixel<AlphaMode::kPremultiplied>{planes, pixels_.data()});
    case AlphaMode::kOpaque:
      return ForEach(planes.pixels, stream, WritePixel<AlphaMode::kOpaque>{planes, pixels_.data()});
  }
}

void DeviceImage::Download(Image8& out) const {
  out.width = width_;
  out.height = height_;
  out.channels = 4;
  out.data.resize(4 * out.pixels());
  pixels_.Download(reinterpret_cast<PixelBytes*>(out.data.data()), *copies_);
  copies_->Wait();
}

void ImageRenderer::Download(RenderedImage& image, PhaseTimes& times) {
  image_.Download(image, stream());
  Finish(times);
}

void ImageRenderer::Keep(AlphaMode alpha, std::unique_ptr<DeviceImage>& out, PhaseTimes& times) {
  if (!out) out = std::make_unique<DeviceImage>(stream());
  out->Write(image_, alpha, stream());
  Finish(times);
}

void ImageRenderer::Finish(PhaseTimes& times) {
  stream().Wait();
  rasterizer_->AddForwardTimes();
  times += std::exchange(rasterizer_->times, {});
}

}  // namespace cosplat
