#include "splat/media/image_glance.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace cosplat {
namespace {

Image8 Reduced(const Image8& image, int width, int height) {
  Image8 small(width, height, image.channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int x0 = int(int64_t(x) * image.width / width),
                x1 = std::max(x0 + 1, int(int64_t(x + 1) * image.width / width)),
                y0 = int(int64_t(y) * image.height / height),
                y1 = std::max(y0 + 1, int(int64_t(y + 1) * image.height / height));
      for (int c = 0; c < image.channels; ++c) {
        uint64_t sum = 0;
        for (int v = y0; v < y1; ++v)
          for (int u = x0; u < x1; ++u) sum += image.at(u, v, c);
        small.at(x, y, c) = uint8_t(sum / uint64_t((x1 - x0) * (y1 - y0)));
      }
    }
  return small;
}

double BrightnessOf(const Image8& image, size_t pixel) {
  const uint8_t* p = &image.data[size_t(image.channels) * pixel];
  return image.channels < 3 ? p[0] : (p[0] + 2.0 * p[1] + p[2]) / 4;
}

}  // namespace

Image8 OverBlack(const Image8& image) {
  Image8 rgb(image.width, image.height, 3);
  for (size_t i = 0; i < image.pixels(); ++i) {
    const uint8_t* p = &image.data[size_t(image.channels) * i];
    for (size_t c = 0; c < 3; ++c)
      rgb.data[3 * i + c] =
          uint8_t(p[image.channels < 3 ? 0 : c] * (image.channels == 4 ? p[3] : 255) / 255);
  }
  return rgb;
}

Image8 ReducedTo(const Image8& image, int side) {
  const int longer = std::max(image.width, image.height);
  if (longer <= side) return image;
  return Reduced(image,
                 std::max(1, int(int64_t(image.width) * side / longer)),
                 std::max(1, int(int64_t(image.height) * side / longer)));
}

Glance GlanceOf(const Image8& image) {
  const Image8 small = Reduced(OverBlack(image), 8, 8);
  Glance glance;
  for (size_t i = 0; i < glance.size(); ++i)
    glance[i] = uint8_t(std::lround(BrightnessOf(small, i)));
  return glance;
}

double DifferenceOf(const Glance& a, const Glance& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / double(a.size());
}

double ContrastOf(const Image8& image) {
  double sum = 0, squares = 0;
  size_t count = 0;
  for (size_t i = 0; i < image.pixels(); ++i) {
    if (image.channels == 4 && image.data[4 * i + 3] < 128) continue;
    const double value = BrightnessOf(image, i);
    sum += value, squares += value * value, ++count;
  }
  if (count == 0) return 0;
  const double mean = sum / double(count);
  return std::sqrt(std::max(0.0, squares / double(count) - mean * mean));
}

Sighting Sight(const Camera& camera, const float* p_in_world) {
  Sighting s{};
  for (int r = 0; r < 3; ++r) {
    s.in_camera[size_t(r)] = camera.translation[size_t(r)];
    for (int k = 0; k < 3; ++k)
      s.in_camera[size_t(r)] += camera.rotation[size_t(3 * r + k)] * p_in_world[k];
  }
  const float z = s.in_camera[2];
  if (!(z > 0)) return s;
  s.x = camera.fx * s.in_camera[0] / z + camera.cx;
  s.y = camera.fy * s.in_camera[1] / z + camera.cy;
  s.inside = s.x >= 0 && s.y >= 0 && s.x < float(camera.width) && s.y < float(camera.height);
  return s;
}

int GreatestAlpha(const Image8& image) {
  if (image.channels != 4) return 255;
  int greatest = 0;
  for (size_t i = 3; i < image.data.size(); i += 4)
    greatest = std::max<int>(greatest, image.data[i]);
  return greatest;
}

int SmallestAlpha(const Image8& image) {
  int smallest = 255;
  for (size_t i = 3; image.channels == 4 && i < image.data.size(); i += 4)
    smallest = std::min<int>(smallest, image.data[i]);
  return smallest;
}

}  // namespace cosplat
