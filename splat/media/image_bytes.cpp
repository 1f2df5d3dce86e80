// Conversion between bytes and floats: the part of image_io.h that needs no library.
#include <algorithm>
#include <cmath>
#include <string>

#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/media/image_io.h"

namespace cosplat {

Image8 ToBytes(const Image& image) {
  Image8 bytes(image.width, image.height, image.channels);
  for (size_t i = 0; i < image.data.size(); ++i) {
    if (std::isnan(image.data[i])) {
      const size_t pixel = i / image.channels;
      throw Error("image",
                  Format("pixel ({}, {}) is NaN", pixel % image.width, pixel / image.width));
    }
    bytes.data[i] = uint8_t(std::clamp(image.data[i], 0.f, 1.f) * 255 + 0.5f);
  }
  return bytes;
}

Image ToFloat(const Image8& image) {
  Image result(image.width, image.height, image.channels);
  for (size_t i = 0; i < image.data.size(); ++i) result.data[i] = image.data[i] / 255.f;
  return result;
}

}  // namespace cosplat
