// The OpenGL texture that holds the window's image.
//
// Image8 -> Upload, or DeviceImage -> Show -> texture -> ImGui. All members, including the
// destructor, require the context of construction to be current.
#pragma once

#include <memory>

#include "splat/base/image.h"
#include "splat/render/device_texture.h"

namespace cosplat::viewer {

class ImageTexture {
 public:
  // make_device_texture: may be empty; Show must then not be called.
  explicit ImageTexture(DeviceTextureMaker make_device_texture);
  ~ImageTexture();
  ImageTexture(const ImageTexture&) = delete;
  ImageTexture& operator=(const ImageTexture&) = delete;

  unsigned name() const { return name_; }

  // RGBA, from host memory.
  void Upload(const Image8& image);
  // From the device that rendered it. Throws Error if the device and OpenGL cannot share the
  // texture; Upload still works then.
  void Show(const DeviceImage& picture);

 private:
  void Resize(int width, int height);

  DeviceTextureMaker make_device_texture_;
  unsigned name_ = 0;
  int width_ = 0, height_ = 0;
  std::unique_ptr<DeviceTexture> device_texture_;  // of this storage; null until needed
};

}  // namespace cosplat::viewer
