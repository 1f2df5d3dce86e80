// Copies device images into an OpenGL texture without a detour through host memory.
//
// DeviceImage -> Fill -> texture, in the thread that owns the OpenGL context.
#pragma once

#include <functional>
#include <memory>

#include "splat/render/device.h"
#include "splat/render/device_image.h"

namespace cosplat {

// An OpenGL texture registered with the device for the lifetime of this object. All calls,
// including the destructor, must come from the thread whose context the texture belongs to.
class DeviceTexture {
 public:
  virtual ~DeviceTexture() = default;
  // Copies the image, which must be on this device and have the texture's size, into the texture,
  // ready for subsequent OpenGL draws. The image may be overwritten immediately afterwards. Throws
  // Error if the driver refuses.
  virtual void Fill(const DeviceImage& image) = 0;
};

// Makes a DeviceTexture for an OpenGL texture (its name) with RGBA8 storage, which must not change
// in the meantime. Throws Error if the context runs on another device or cannot share its textures.
using DeviceTextureMaker = std::function<std::unique_ptr<DeviceTexture>(unsigned texture)>;

// Empty for the CPU.
DeviceTextureMaker DeviceTextureOn(Device device);

namespace cuda {

// Uses OpenGL interoperability (splat/render/cuda/gl_texture.cpp). In a library of its own
// (cosplat::render_gl), since it needs the OpenGL header. Source: CUDA Runtime API, "Graphics
// Interoperability" and "OpenGL Interoperability".
std::unique_ptr<DeviceTexture> MakeGlTexture(unsigned texture);

}  // namespace cuda

}  // namespace cosplat
