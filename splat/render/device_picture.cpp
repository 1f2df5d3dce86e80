#include "splat/render/device_picture.h"

#include "splat/device/for_each.h"

namespace cosplat {

void DevicePicture::Write(const RenderedImage& image, AlphaMode alpha, Stream& stream) {
  width_ = image.width;
  height_ = image.height;
  pixels_.Refill(image.transmittance.size(), stream);
  const PicturePlanes planes{image.color.data(), image.transmittance.data(), pixels_.size()};
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

void DevicePicture::Download(Image8& out) const {
  out.width = width_;
  out.height = height_;
  out.channels = 4;
  out.data.resize(4 * out.pixels());
  pixels_.Download(reinterpret_cast<PixelBytes*>(out.data.data()), *copies_);
  copies_->Wait();
}

}  // namespace cosplat
