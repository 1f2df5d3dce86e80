// The OpenGL texture of the image that the window shows.
//
// Image8 -> Upload, or DeviceImage -> Show -> texture -> ImGui. Everything, the end included,
// with the context that it was made in.
#pragma once

#include <memory>

#include "splat/base/image.h"
#include "splat/render/device_texture.h"

namespace cosplat::viewer {

class ImageTexture {
 public:
  // make_device_texture: may be empty; then there is no Show.
  explicit ImageTexture(DeviceTextureMaker make_device_texture);
  ~ImageTexture();
  ImageTexture(const ImageTexture&) = delete;
  ImageTexture& operator=(const ImageTexture&) = delete;

  unsigned name() const { return name_; }

  // RGBA, from the host's memory.
  void Upload(const Image8& image);
  // From the device that drew it. Throws Error where it and OpenGL do not share the texture; Upload
  // works all the same.
  void Show(const DeviceImage& picture);

 private:
  void Resize(int width, int height);

  DeviceTextureMaker make_device_texture_;
  unsigned name_ = 0;
  int width_ = 0, height_ = 0;
  std::unique_ptr<DeviceTexture> device_texture_;  // of this storage; null until it is needed
};

}  // namespace cosplat::viewer
