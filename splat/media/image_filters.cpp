#include "splat/media/image_filters.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace cosplat {
namespace {

// Sums of a weighted linear regression on colours, in the order in which they are kept per pixel.
struct Sums {
  float weight, input;
  std::array<float, 3> color, color_input;
  std::array<float, 6> color_color;  // 00 01 02 11 12 22
};
constexpr int kSums = sizeof(Sums) / sizeof(float);

// Slopes and offset of the regression that `s` are the means of.
std::array<float, 4> Fit(const Sums& s, float epsilon) {
  const float scale = 1 / std::max(s.weight, 1e-6f);
  const float y = s.input * scale;
  std::array<float, 3> m{}, b{};
  for (size_t c = 0; c < 3; ++c) {
    m[c] = s.color[c] * scale;
    b[c] = s.color_input[c] * scale - m[c] * y;
  }
  const auto& q = s.color_color;
  const float xx = q[0] * scale - m[0] * m[0] + epsilon, xy = q[1] * scale - m[0] * m[1],
              xz = q[2] * scale - m[0] * m[2], yy = q[3] * scale - m[1] * m[1] + epsilon,
              yz = q[4] * scale - m[1] * m[2], zz = q[5] * scale - m[2] * m[2] + epsilon;
  // The inverse by cofactors; the ridge keeps the determinant above epsilon³.
  const float cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy,
              cyy = xx * zz - xz * xz, cyz = xy * xz - xx * yz, czz = xx * yy - xy * xy;
  const float inverse = 1 / (xx * cxx + xy * cxy + xz * cxz);
  const std::array<float, 3> a{(cxx * b[0] + cxy * b[1] + cxz * b[2]) * inverse,
                               (cxy * b[0] + cyy * b[1] + cyz * b[2]) * inverse,
                               (cxz * b[0] + cyz * b[1] + czz * b[2]) * inverse};
  return {a[0], a[1], a[2], y - a[0] * m[0] - a[1] * m[1] - a[2] * m[2]};
}

}  // namespace

Image Dilated(const Image& mask, int radius) {
  Image result = BoxMean(mask, radius);
  for (float& mean : result.data) mean = mean > 1e-6f ? 1.f : 0.f;
  return result;
}

Image GuidedFilter(
    const Image& guide, const Image& input, const Image& weight, int radius, float epsilon) {
  Image products(guide.width, guide.height, kSums);
  for (size_t i = 0; i < guide.pixels(); ++i) {
    const float* c = &guide.data[3 * i];
    const float w = weight.data[i], y = w * input.data[i];
    Sums s{w, y, {w * c[0], w * c[1], w * c[2]}, {y * c[0], y * c[1], y * c[2]}, {}};
    s.color_color = {w * c[0] * c[0],
                     w * c[0] * c[1],
                     w * c[0] * c[2],
                     w * c[1] * c[1],
                     w * c[1] * c[2],
                     w * c[2] * c[2]};
    std::memcpy(&products.data[kSums * i], &s, sizeof s);
  }
  products = BoxMean(products, radius);
  Image fits(guide.width, guide.height, 4);
  for (size_t i = 0; i < guide.pixels(); ++i) {
    Sums s;
    std::memcpy(&s, &products.data[kSums * i], sizeof s);
    const std::array<float, 4> fit = Fit(s, epsilon);
    std::copy(fit.begin(), fit.end(), &fits.data[4 * i]);
  }
  fits = BoxMean(fits, radius);
  Image result(guide.width, guide.height, 1);
  for (size_t i = 0; i < guide.pixels(); ++i) {
    const float *c = &guide.data[3 * i], *f = &fits.data[4 * i];
    result.data[i] = f[0] * c[0] + f[1] * c[1] + f[2] * c[2] + f[3];
  }
  return result;
}

}  // namespace cosplat
