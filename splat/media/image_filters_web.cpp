// What of image_filters.h is OpenCV's elsewhere.
#include <algorithm>
#include <vector>

#include "splat/media/image_filters.h"

namespace cosplat {
namespace {

// Means of 2 * radius + 1 neighbours of `count` elements, each of n numbers, `stride` apart.
// Beyond an end the elements come again in reverse, the last one first.
void MeanAlong(const float* in, float* out, int count, size_t stride, size_t n, int radius) {
  const auto at = [&](int i) {
    i %= 2 * count;
    if (i < 0) i += 2 * count;
    return in + stride * size_t(i < count ? i : 2 * count - 1 - i);
  };
  std::vector<double> sums(n);
  const auto add = [&](int i, double sign) {
    for (size_t c = 0; c < n; ++c) sums[c] += sign * at(i)[c];
  };
  for (int i = -radius; i <= radius; ++i) add(i, 1);
  for (int i = 0; i < count; ++i) {
    for (size_t c = 0; c < n; ++c) out[stride * size_t(i) + c] = float(sums[c] / (2 * radius + 1));
    add(i + radius + 1, 1);
    add(i - radius, -1);
  }
}

}  // namespace

Image BoxMean(const Image& image, int radius) {
  const size_t n = size_t(image.channels), row = n * size_t(image.width);
  Image across(image.width, image.height, image.channels), mean = across;
  for (int y = 0; y < image.height; ++y)
    MeanAlong(
        &image.data[row * size_t(y)], &across.data[row * size_t(y)], image.width, n, n, radius);
  // Whole rows are the elements of the columns.
  MeanAlong(across.data.data(), mean.data.data(), image.height, row, row, radius);
  return mean;
}

ConnectedParts PartsOf(const Image8& mask) {
  ConnectedParts parts;
  parts.labels.assign(mask.pixels(), 0);
  std::vector<size_t> open;
  const auto reach = [&](size_t i) {
    if (mask.data[i] == 0 || parts.labels[i] != 0) return;
    parts.labels[i] = parts.count;
    open.push_back(i);
  };
  const size_t width = size_t(mask.width);
  for (size_t begin = 0; begin < mask.pixels(); ++begin) {
    if (mask.data[begin] == 0 || parts.labels[begin] != 0) continue;
    ++parts.count;
    reach(begin);
    while (!open.empty()) {
      const size_t i = open.back();
      open.pop_back();
      if (i % width > 0) reach(i - 1);
      if (i % width + 1 < width) reach(i + 1);
      if (i >= width) reach(i - width);
      if (i + width < mask.pixels()) reach(i + width);
    }
  }
  return parts;
}

}  // namespace cosplat
