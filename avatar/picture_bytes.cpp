#include "avatar/picture_bytes.h"

#include <algorithm>
#include <limits>

#include "avatar/parallel_for.h"

namespace cosplat {
namespace {

constexpr size_t kPixelsPerTask = 8192;

// [0, 1] to [0, 255], rounded; what is not a number is 0.
uint8_t ToByte(float x) { return x > 0 ? uint8_t(std::min(x, 1.0f) * 255 + 0.5f) : uint8_t(0); }

// Row(y) for every row, some of them on each core.
template <class Row>
void ForRows(const RenderedImage& image, const Row& row) {
  const size_t rows = std::max<size_t>(1, kPixelsPerTask / size_t(std::max(1, image.width)));
  ParallelForRanges(size_t(image.height), rows, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) row(y);
  });
}

template <AlphaMode kMode>
void WriteRows(const RenderedImage& image, bool blue_first, uint8_t* pixels, ptrdiff_t stride) {
  const size_t width = size_t(image.width), plane = width * size_t(image.height);
  const int red = blue_first ? 2 : 0, blue = 2 - red;
  const int place[3] = {red, 1, blue};
  ForRows(image, [&](size_t y) {
    uint8_t* out = pixels + ptrdiff_t(y) * stride;
    for (size_t p = y * width; p < (y + 1) * width; ++p, out += 4) {
      const float alpha = 1 - image.transmittance[p];
      for (int c = 0; c < 3; ++c) {
        float color = image.color[size_t(c) * plane + p];
        if (kMode == AlphaMode::kStraight) color = alpha > 0 ? color / alpha : 0.0f;
        if (kMode == AlphaMode::kPremultiplied) color = std::min(color, alpha);
        out[place[c]] = ToByte(color);
      }
      out[3] = kMode == AlphaMode::kOpaque ? uint8_t(255) : ToByte(alpha);
    }
  });
}

}  // namespace

void WritePicture(const RenderedImage& image,
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
