// An image that stayed on the device against the host's bytes of the same drawing's numbers.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

#include "splat/render/device_image.h"
#include "splat/render/kernels/pixel_bytes.h"
#include "splat/render/rasterizer.h"

namespace cosplat::test {

// Off by one where a compiler fuses the rounding's product and sum: at most one byte in a hundred.
template <AlphaMode kMode>
void ExpectBytesOf(const RenderedImage& image, const DeviceImage& stays) {
  Image8 bytes;
  stays.Download(bytes);
  ASSERT_EQ(bytes.width, image.width);
  ASSERT_EQ(bytes.height, image.height);
  ASSERT_EQ(bytes.data.size(), 4 * image.transmittance.size());
  const ImagePlanes planes{image.color.data(), image.transmittance.data(), bytes.pixels()};
  size_t off = 0;
  for (size_t p = 0; p < bytes.pixels(); ++p) {
    const PixelBytes expected = math::PixelAt<kMode>(planes, p);
    const uint8_t channels[4] = {expected.red, expected.green, expected.blue, expected.alpha};
    for (size_t c = 0; c < 4; ++c) {
      const int difference = std::abs(int(bytes.data[4 * p + c]) - int(channels[c]));
      ASSERT_LE(difference, 1) << p << " channel " << c;
      off += size_t(difference);
    }
  }
  EXPECT_LE(off, bytes.data.size() / 100);
}

}  // namespace cosplat::test
