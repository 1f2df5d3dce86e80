#include "splat/eval/metrics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "splat/base/error.h"
#include "splat/media/image_io.h"
#include "splat/train/loss/loss.h"

namespace cosplat {
namespace {

std::string SizeOf(const Image8& image) {
  return SizeText(image.width, image.height) + "x" + std::to_string(image.channels);
}

double SquaredDifference(const Image8& a, const Image8& b, size_t pixel) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    const double d = (double(a.data[3 * pixel + c]) - b.data[3 * pixel + c]) / 255;
    sum += d * d;
  }
  return sum / 3;
}

std::optional<double> ToDecibel(double squared, double weight) {
  if (weight <= 0) return {};
  return squared > 1e-10 * weight ? -10 * std::log10(squared / weight) : 100;
}

// Highlights are where colours depend most on the viewing direction.
std::optional<double> HighlightPsnr(const Image8& rendered,
                                    const Image8& truth,
                                    const Image8& mask) {
  constexpr size_t kShare = 50;
  std::vector<std::pair<int, size_t>> by_brightness;
  for (size_t i = 0; i < truth.pixels(); ++i)
    if (mask.data[i] == 255)
      by_brightness.push_back(
          {truth.data[3 * i] + truth.data[3 * i + 1] + truth.data[3 * i + 2], i});
  const size_t count = by_brightness.size() / kShare;
  std::partial_sort(by_brightness.begin(),
                    by_brightness.begin() + std::ptrdiff_t(count),
                    by_brightness.end(),
                    std::greater<>());
  double sum = 0;
  for (size_t k = 0; k < count; ++k)
    sum += SquaredDifference(rendered, truth, by_brightness[k].second);
  return ToDecibel(sum, double(count));
}

}  // namespace

bool HasContent(const Image8& truth) {
  // Noise and JPEG's artefacts in a picture of one colour span a few of the 255 steps.
  constexpr int kOneColour = 8;
  for (int c = 0; c < truth.channels; ++c) {
    int min = 255, max = 0;
    for (size_t i = size_t(c); i < truth.data.size(); i += size_t(truth.channels)) {
      min = std::min(min, int(truth.data[i]));
      max = std::max(max, int(truth.data[i]));
      if (max - min > kOneColour) return true;
    }
  }
  return false;
}

std::optional<double> MaskedPsnr(const Image8& rendered, const Image8& truth, const Image8& mask) {
  double sum = 0, weight = 0;
  for (size_t i = 0; i < truth.pixels(); ++i) {
    const double w = mask.data[i] / 255.0;
    sum += w * SquaredDifference(rendered, truth, i);
    weight += w;
  }
  return ToDecibel(sum, weight);
}

Image8 Inside(Image8 mask, const Crop& box) {
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (x < box.x || x >= box.x + box.width || y < box.y || y >= box.y + box.height)
        mask.at(x, y, 0) = 0;
  return mask;
}

Image8 OverBackground(const Image8& image, const std::array<float, 3>& background) {
  Buffer<float> planar;
  CompositeTarget(image, background, planar);
  Image over(image.width, image.height, 3);
  for (size_t i = 0; i < over.data.size(); ++i)
    over.data[i] = planar[i % 3 * over.pixels() + i / 3];
  return ToBytes(over);
}

ImageMetrics CompareImages(const Image8& rendered, const Image8& truth, const Image8* mask) {
  if (rendered.width != truth.width || rendered.height != truth.height || rendered.channels != 3 ||
      truth.channels != 3)
    throw Error("images",
                "have sizes " + SizeOf(rendered) + " and " + SizeOf(truth) +
                    ", expected equal sizes and 3 channels");
  if (mask && (mask->width != truth.width || mask->height != truth.height || mask->channels != 1))
    throw Error("mask", SizeOf(*mask) + " for an image of " + SizeOf(truth));
  ImageMetrics m;
  Buffer<float> a, b;
  CompositeTarget(rendered, {0, 0, 0}, a);
  CompositeTarget(truth, {0, 0, 0}, b);
  m.psnr = Psnr(a, b);
  m.ssim = MeanSsim(a, truth, {0, 0, 0});
  if (mask) {
    m.psnr_mask = MaskedPsnr(rendered, truth, *mask);
    m.psnr_highlight = HighlightPsnr(rendered, truth, *mask);
  }
  return m;
}

}  // namespace cosplat
