// A picture that stays on the device that drew it.
//
// SceneRenderer, AvatarRenderer -> DevicePicture -> DeviceTexture (splat/render/device_texture.h)
// or, where it is wanted on the host after all, Download.
#pragma once

#include "splat/base/image.h"

namespace cosplat {

// RGBA bytes, all drawn: whoever gets it need not wait. Of one device; give it back to whoever made
// it, and its memory is used again. One call at a time, in any thread.
class DevicePicture {
 public:
  virtual ~DevicePicture() = default;
  virtual int width() const = 0;
  virtual int height() const = 0;
  // Keeps the memory of `out`.
  virtual void Download(Image8& out) const = 0;
};

}  // namespace cosplat
