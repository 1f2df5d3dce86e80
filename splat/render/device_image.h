// An image that stays on the device that drew it.
//
// SceneRenderer, AvatarRenderer -> DeviceImage -> DeviceTexture (splat/render/device_texture.h)
// or, where it is wanted on the host after all, Download.
#pragma once

#include <memory>

#include "splat/base/image.h"
#include "splat/render/kernels/pixel_bytes.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// RGBA bytes. Once it was waited for, whoever gets it need not wait. Of one device; give it back to
// whoever made it, and its memory is used again. One call at a time, in any thread.
class DeviceImage {
 public:
  explicit DeviceImage(const Stream& stream) : copies_(stream.Another()) {}

  // The image's floats as bytes; they are there when the stream has been waited for.
  void Write(const RenderedImage& image, AlphaMode alpha, Stream& stream);

  int width() const { return width_; }
  int height() const { return height_; }
  const PixelBytes* data() const { return pixels_.data(); }  // [height, width]
  // Keeps the memory of `out`.
  void Download(Image8& out) const;

 private:
  int width_ = 0, height_ = 0;
  Buffer<PixelBytes> pixels_;
  std::unique_ptr<Stream> copies_;
};

}  // namespace cosplat
