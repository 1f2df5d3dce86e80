#include "avatar/play/image_bytes.h"

#include <algorithm>
#include <limits>

#include "splat/device/for_each.h"
#include "splat/render/kernels/pixel_bytes.h"

namespace cosplat {
namespace {

constexpr size_t kPixelsPerTask = 8192;

// Calls row(y) for every row, in parallel.
template <class Row>
void ForRows(const RenderedImage& image, const Row& row) {
  const size_t rows = std::max<size_t>(1, kPixelsPerTask / size_t(std::max(1, image.width)));
  ParallelForRanges(size_t(image.height), rows, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) row(y);
  });
}

template <AlphaMode kMode>
void WriteRows(const RenderedImage& image, bool blue_first, uint8_t* pixels, ptrdiff_t stride) {
  const size_t width = size_t(image.width);
  const ImagePlanes planes{
      image.color.data(), image.transmittance.data(), width * size_t(image.height)};
  const int red = blue_first ? 2 : 0, blue = 2 - red;
  ForRows(image, [&](size_t y) {
    uint8_t* out = pixels + ptrdiff_t(y) * stride;
    for (size_t p = y * width; p < (y + 1) * width; ++p, out += 4) {
      const PixelBytes pixel = math::PixelAt<kMode>(planes, p);
      out[red] = pixel.red;
      out[1] = pixel.green;
      out[blue] = pixel.blue;
      out[3] = pixel.alpha;
    }
  });
}

}  // namespace

void WriteImageBytes(const RenderedImage& image,
                     PixelLayout layout,
                     uint8_t* pixels,
                     ptrdiff_t stride) {
  switch (layout.alpha) {
    case AlphaMode::kStraight:
      return WriteRows<AlphaMode::kStraight>(image, layout.blue_first, pixels, stride);
    case AlphaMode::kPremultiplied:
      return WriteRows<AlphaMode::kPremultiplied>(image, layout.blue_first, pixels, stride);
    case AlphaMode::kOpaque:
      return WriteRows<AlphaMode::kOpaque>(image, layout.blue_first, pixels, stride);
  }
}

void WriteDepth(const RenderedImage& image, float* depth, ptrdiff_t stride) {
  const size_t width = size_t(image.width);
  ForRows(image, [&](size_t y) {
    float* out = depth + ptrdiff_t(y) * (stride / ptrdiff_t(sizeof(float)));
    for (size_t x = 0; x < width; ++x) {
      const size_t p = y * width + x;
      const float alpha = 1 - image.transmittance[p];
      out[x] = alpha > 0 ? image.color[p] / alpha : std::numeric_limits<float>::infinity();
    }
  });
}

}  // namespace cosplat
