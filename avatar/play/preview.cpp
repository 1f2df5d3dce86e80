#include "avatar/play/preview.h"

#include <algorithm>

#include "splat/device/for_each.h"

namespace cosplat {
namespace {

// The centre of a full-resolution pixel lies a quarter of a half-resolution pixel from the nearest
// half-resolution centre.
constexpr float kQuarter = 0.25f;

// A quarter of the way from `near` to `other`; exactly `near` if both are equal.
float Between(float near, float other) { return near + kQuarter * (other - near); }

// Computes one row. near, other: the half-resolution rows on both sides of it, half_width long.
// blended: scratch memory for half_width + 2 numbers.
void EnlargeRow(
    const float* near, const float* other, int half_width, int width, float* blended, float* out) {
  for (int i = 0; i < half_width; ++i) blended[i + 1] = Between(near[i], other[i]);
  blended[0] = blended[1];
  blended[half_width + 1] = blended[half_width];
  for (int i = 0; i < width / 2; ++i) {
    out[2 * i] = Between(blended[i + 1], blended[i]);
    out[2 * i + 1] = Between(blended[i + 1], blended[i + 2]);
  }
  if (width % 2 == 1) out[width - 1] = Between(blended[half_width], blended[half_width - 1]);
}

}  // namespace

Camera HalfResolution(const Camera& camera) {
  Camera half = camera;
  half.width = (camera.width + 1) / 2;
  half.height = (camera.height + 1) / 2;
  for (float* px : {&half.fx, &half.fy, &half.cx, &half.cy}) *px *= 0.5f;
  return half;
}

void EnlargeTwice(const RenderedImage& half, int width, int height, RenderedImage& out) {
  out.width = width;
  out.height = height;
  out.color.resize(3 * size_t(width) * height);
  out.transmittance.resize(size_t(width) * height);
  constexpr size_t kRowsPerTask = 32;
  ParallelForRanges(4 * size_t(height), kRowsPerTask, [&](size_t begin, size_t end) {
    std::vector<float> blended(half.width + 2);
    for (size_t r = begin; r < end; ++r) {
      const size_t plane = r / height;
      const int y = int(r % height), near = y / 2;
      const int other = std::clamp(y % 2 == 0 ? near - 1 : near + 1, 0, half.height - 1);
      const size_t plane_size = size_t(half.width) * half.height;
      const float* in =
          plane < 3 ? half.color.data() + plane * plane_size : half.transmittance.data();
      float* const row =
          plane < 3 ? out.color.data() + r * width : out.transmittance.data() + size_t(y) * width;
      EnlargeRow(in + size_t(near) * half.width,
                 in + size_t(other) * half.width,
                 half.width,
                 width,
                 blended.data(),
                 row);
    }
  });
}

}  // namespace cosplat
