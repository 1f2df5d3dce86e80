// Puts images that stayed on a device into an OpenGL texture; the host's memory sees none of it.
//
// DeviceImage -> Fill -> texture, in the thread that has OpenGL's context.
#pragma once

#include <functional>
#include <memory>

#include "splat/render/device.h"
#include "splat/render/device_image.h"

namespace cosplat {

// A texture as the device knows it, for as long as this is there. Everything, the end included, is
// done in the thread whose context the texture is of.
class DeviceTexture {
 public:
  virtual ~DeviceTexture() = default;
  // The image, which is of this device and the texture's size, is in the texture for whatever
  // OpenGL draws next; it may be drawn over at once. Throws Error where the driver refuses.
  virtual void Fill(const DeviceImage& image) = 0;
};

// Of a texture (OpenGL's name) with storage for RGBA8, which stays as it is meanwhile. Throws Error
// where the context's device is another, or cannot share its textures.
using DeviceTextureMaker = std::function<std::unique_ptr<DeviceTexture>(unsigned texture)>;

// Empty for the CPU.
DeviceTextureMaker DeviceTextureOn(Device device);

namespace cuda {

// By OpenGL interoperability (splat/render/cuda/gl_texture.cpp): a library of its own
// (cosplat::render_gl), since it needs OpenGL's header. Source: CUDA Runtime API, "Graphics
// Interoperability" and "OpenGL Interoperability".
std::unique_ptr<DeviceTexture> MakeGlTexture(unsigned texture);

}  // namespace cuda

}  // namespace cosplat
