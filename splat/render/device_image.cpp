#include "splat/render/device_image.h"

#include <utility>

#include "splat/device/buffer.h"
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

ImageRenderer::ImageRenderer(std::unique_ptr<Rasterizer> rasterizer)
    : rasterizer_(std::move(rasterizer)),
      tape_(rasterizer_->MakeTape(false)),
      counts_(rasterizer_->stream()) {
  exceeded_.Refill(1, stream());
}

void ImageRenderer::Forward(const WorldGaussians& gaussians,
                            Basis basis,
                            const Camera& camera,
                            const RenderSettings& settings) {
  frame_ = {gaussians, basis, camera, settings};
  Submit(counts_.Last().instances == 0);
}

void ImageRenderer::Submit(bool waits) {
  const size_t last = counts_.Last().instances;
  if (!waits) tape_->Expect(last + last / kHeadRoom, exceeded_.data());
  rasterizer_->Forward(
      frame_.gaussians, frame_.basis, frame_.camera, frame_.settings, image_, *tape_);
  counts_.Ask(tape_->counts(), stream());
}

template <class Copy>
void ImageRenderer::Finish(const Copy& copy, PhaseTimes& times) {
  copy();
  stream().Wait();
  if (counts_.Last().instances > tape_->capacity()) {
    Submit(true);
    copy();
    stream().Wait();
  }
  rasterizer_->AddForwardTimes();
  times += std::exchange(rasterizer_->times, {});
}

void ImageRenderer::Download(RenderedImage& image, PhaseTimes& times) {
  image.color.RefillForReadback(image_.color.size(), stream());
  image.transmittance.RefillForReadback(image_.transmittance.size(), stream());
  Finish([&] { image_.Download(image, stream()); }, times);
}

void ImageRenderer::Keep(AlphaMode alpha, std::unique_ptr<DeviceImage>& out, PhaseTimes& times) {
  if (!out) out = std::make_unique<DeviceImage>(stream());
  Finish([&] { out->Write(image_, alpha, stream()); }, times);
}

}  // namespace cosplat
