#include "flame/fit/band_pass.h"

#include <algorithm>
#include <cmath>

#include "splat/base/image_io.h"

namespace cosplat::internal {
namespace {

// Radii of three box filters in a row, which come close to a Gaussian of the same width.
constexpr int kFineRadius = 1, kCoarseRadius = 8;
// Blurred brightness is divided by the blurred matte, but by no less.
constexpr float kMinMatte = 0.05f;

// One box filter along the rows; the result is transposed.
Image BoxFilter(const Image& in, int radius) {
  Image out(in.height, in.width, 1);
  for (int y = 0; y < in.height; ++y) {
    const auto at = [&](int x) { return double(in.at(std::clamp(x, 0, in.width - 1), y, 0)); };
    double sum = 0;
    for (int x = -radius; x <= radius; ++x) sum += at(x);
    for (int x = 0; x < in.width; ++x) {
      out.at(y, x, 0) = float(sum / (2 * radius + 1));
      sum += at(x + radius + 1) - at(x - radius);
    }
  }
  return out;
}

Image Blur(Image image, int radius) {
  for (int pass = 0; pass < 3; ++pass) image = BoxFilter(BoxFilter(image, radius), radius);
  return image;
}

Image8 CropOf(const Image8& frame, int left, int top, int width, int height) {
  Image8 out(width, height, frame.channels);
  for (int y = 0; y < height; ++y)
    std::copy_n(&frame.at(left, top + y, 0), width * frame.channels, &out.at(0, y, 0));
  return out;
}

}  // namespace

BandPassed BandPass(const Image8& frame, const std::array<double, 4>& box, double scale) {
  const int left = int(std::clamp(box[0], 0.0, frame.width - 2.0));
  const int top = int(std::clamp(box[1], 0.0, frame.height - 2.0));
  const int right = int(std::clamp(std::ceil(box[2]), left + 2.0, double(frame.width)));
  const int bottom = int(std::clamp(std::ceil(box[3]), top + 2.0, double(frame.height)));
  Image8 part = CropOf(frame, left, top, right - left, bottom - top);
  if (scale < 1)
    part = ResizeByArea(part,
                        std::max(2, int(std::lround(part.width * scale))),
                        std::max(2, int(std::lround(part.height * scale))));
  BandPassed out;
  out.scale = double(part.width) / (right - left);
  out.corner = {double(left), double(top)};
  Image matte(part.width, part.height, 1, 1.0f), grey = matte;
  for (size_t i = 0; i < part.pixels(); ++i) {
    const uint8_t* const p = &part.data[i * size_t(part.channels)];
    if (part.channels == 4) matte.data[i] = float(p[3]) / 255;
    // Luma of Rec. 601
    grey.data[i] = matte.data[i] * (0.299f * p[0] + 0.587f * p[1] + 0.114f * p[2]);
  }
  const Image fine = Blur(grey, kFineRadius), fine_matte = Blur(matte, kFineRadius);
  const Image coarse = Blur(grey, kCoarseRadius), coarse_matte = Blur(matte, kCoarseRadius);
  out.image = std::move(grey);
  for (size_t i = 0; i < part.pixels(); ++i)
    out.image.data[i] = fine.data[i] / std::max(fine_matte.data[i], kMinMatte) -
                        coarse.data[i] / std::max(coarse_matte.data[i], kMinMatte);
  return out;
}

BrightnessAt SampleAt(const BandPassed& image, double x, double y) {
  // Pixels' centres are at halves.
  const double u = (x - image.corner[0]) * image.scale - 0.5;
  const double v = (y - image.corner[1]) * image.scale - 0.5;
  const int width = image.image.width, height = image.image.height;
  if (!(u >= 0 && v >= 0 && u < width - 1 && v < height - 1)) return {};
  const int i = int(u), j = int(v);
  const double a = u - i, b = v - j;
  const float* const p = &image.image.at(i, j, 0);
  const double top = (1 - a) * p[0] + a * p[1], bottom = (1 - a) * p[width] + a * p[width + 1];
  BrightnessAt out;
  out.inside = true;
  out.value = (1 - b) * top + b * bottom;
  out.d_x = image.scale * ((1 - b) * (double(p[1]) - p[0]) + b * (double(p[width + 1]) - p[width]));
  out.d_y = image.scale * (bottom - top);
  return out;
}

}  // namespace cosplat::internal
