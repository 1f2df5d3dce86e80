// Images with interleaved channels and rows from the top, as used for files, rendering and losses.
// Values are display-referred sRGB throughout, as in 3DGS: nothing is linearised.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cosplat {

template <class T>
struct BasicImage {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<T> data;  // [height, width, channels]

  BasicImage() = default;
  BasicImage(int width, int height, int channels, T fill = T(0))
      : width(width),
        height(height),
        channels(channels),
        data(size_t(width) * height * channels, fill) {}

  bool empty() const { return data.empty(); }
  size_t pixels() const { return size_t(width) * height; }
  T& at(int x, int y, int c) { return data[(size_t(y) * width + x) * channels + c]; }
  const T& at(int x, int y, int c) const { return data[(size_t(y) * width + x) * channels + c]; }
};

using Image = BasicImage<float>;     // [0, 1]
using Image8 = BasicImage<uint8_t>;  // [0, 255]; four channels mean straight (unmultiplied) alpha

// A part of an image, px; empty: none.
struct Crop {
  int x = 0, y = 0, width = 0, height = 0;

  bool operator==(const Crop&) const = default;
  bool empty() const { return width <= 0 || height <= 0; }
};

// crop: within the image.
template <class T>
BasicImage<T> Cropped(const BasicImage<T>& image, const Crop& crop) {
  BasicImage<T> part(crop.width, crop.height, image.channels);
  const size_t row = size_t(crop.width) * size_t(image.channels);
  for (int y = 0; y < crop.height; ++y)
    std::copy_n(&image.at(crop.x, crop.y + y, 0), row, &part.at(0, y, 0));
  return part;
}

// Copies an image to column `left` and row `top` of one of as many channels, within it.
template <class T>
void Paste(const BasicImage<T>& part, int left, int top, BasicImage<T>& onto) {
  for (int y = 0; y < part.height; ++y)
    std::copy_n(
        &part.at(0, y, 0), size_t(part.width) * size_t(part.channels), &onto.at(left, top + y, 0));
}

// "640x480", for messages.
inline std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace cosplat
