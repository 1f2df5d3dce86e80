#include <algorithm>
#include <bitset>
#include <set>

#include "splat/media/image_io.h"

namespace cosplat {
namespace {

constexpr uint8_t kHighestLabel = 31;
constexpr size_t kMaxColors = 64;  // of data sets' palettes; an anti-aliased rim has more

// Whether a mask of three channels shows labels by colours: some pixels are no grey, and few are
// alike.
bool HasLabelColors(const Image8& mask) {
  bool colored = false;
  std::set<uint32_t> colors;
  for (size_t i = 0; i < mask.pixels(); ++i) {
    const uint8_t* p = &mask.data[i * mask.channels];
    colored = colored || p[0] != p[1] || p[1] != p[2];
    colors.insert(uint32_t(p[0]) << 16 | uint32_t(p[1]) << 8 | p[2]);
    if (colors.size() > kMaxColors) return false;
  }
  return colored;
}

}  // namespace

bool SaysAlpha(const Image8& image) {
  if (image.channels != 4) return false;
  for (size_t i = 0; i < image.pixels(); ++i)
    if (image.data[4 * i + 3] != 255) return true;
  return false;
}

Image8 RgbOf(const Image8& image) {
  if (image.channels == 3) return image;
  Image8 rgb(image.width, image.height, 3);
  for (size_t i = 0; i < image.pixels(); ++i)
    for (size_t c = 0; c < 3; ++c)
      rgb.data[3 * i + c] = image.data[size_t(image.channels) * i + (image.channels < 3 ? 0 : c)];
  return rgb;
}

Image8 ChannelOf(const Image8& image, int channel) {
  Image8 out(image.width, image.height, 1);
  for (size_t i = 0; i < out.pixels(); ++i)
    out.data[i] = image.data[size_t(image.channels) * i + size_t(channel)];
  return out;
}

Image8 MatteOf(const Image8& mask) {
  Image8 matte(mask.width, mask.height, 1);
  const bool by_alpha = SaysAlpha(mask);
  const size_t colors = size_t(std::min(mask.channels, 3));
  for (size_t i = 0; i < mask.pixels(); ++i) {
    const uint8_t* pixel = &mask.data[i * mask.channels];
    matte.data[i] = by_alpha ? pixel[3] : *std::max_element(pixel, pixel + colors);
  }
  std::bitset<256> values;
  for (const uint8_t value : matte.data) values.set(value);
  size_t highest = 255;
  while (highest > 0 && !values[highest]) --highest;
  const bool labels = highest <= kHighestLabel || (values.count() == 2 && values[0]) ||
                      (colors == 3 && !by_alpha && HasLabelColors(mask));
  if (labels)
    for (uint8_t& value : matte.data) value = value > 0 ? 255 : 0;
  return matte;
}

}  // namespace cosplat
