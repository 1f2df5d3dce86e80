// An image that stays on the device that rendered it.
//
// SceneRenderer, AvatarRenderer -> DeviceImage -> DeviceTexture (splat/render/device_texture.h), or
// Download if it is needed on the host.
#pragma once

#include <memory>

#include "splat/base/image.h"
#include "splat/render/kernels/pixel_bytes.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// RGBA bytes on one device. Once the renderer has waited for the image, its users need not wait.
// Pass it back to the renderer that made it to reuse its memory. May be used from any thread, but
// not concurrently.
class DeviceImage {
 public:
  explicit DeviceImage(const Stream& stream) : copies_(stream.Another()) {}

  // Converts a float image to bytes, which are valid once the stream has been waited for.
  void Write(const RenderedImage& image, AlphaMode alpha, Stream& stream);

  int width() const { return width_; }
  int height() const { return height_; }
  const PixelBytes* data() const { return pixels_.data(); }  // [height, width]
  // Reuses the memory of `out`.
  void Download(Image8& out) const;

 private:
  int width_ = 0, height_ = 0;
  Buffer<PixelBytes> pixels_;
  std::unique_ptr<Stream> copies_;
};

}  // namespace cosplat
