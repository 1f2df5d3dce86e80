#include "flame/fit/face_looks.h"

#include <algorithm>
#include <cmath>

#include "flame/io/landmarks.h"
#include "splat/base/median.h"

namespace cosplat {
namespace {

constexpr float kNoColor = -1;  // of a part that is not in the image

}  // namespace

double SharpnessOf(const Image8& image, const std::vector<std::array<double, 2>>& landmarks) {
  const auto [x0, y0, x1, y1] = BoxOf(landmarks);
  const auto grey = [&](int x, int y) {
    return image.at(x, y, 0) + 2 * image.at(x, y, 1) + image.at(x, y, 2);
  };
  double sum = 0;
  size_t count = 0;
  for (int y = std::max(1, int(y0)); y < std::min(image.height - 1, int(y1)); ++y)
    for (int x = std::max(1, int(x0)); x < std::min(image.width - 1, int(x1)); ++x) {
      const double d =
          grey(x - 1, y) + grey(x + 1, y) + grey(x, y - 1) + grey(x, y + 1) - 4.0 * grey(x, y);
      sum += d * d;
      ++count;
    }
  return count > 0 ? sum / double(count) : 0;
}

std::vector<float> FaceColorsOf(const Image8& image,
                                const std::vector<std::array<double, 2>>& landmarks) {
  constexpr int kParts = 4;
  const auto [x0, y0, x1, y1] = BoxOf(landmarks);
  std::vector<float> colors(3 * kParts * kParts);
  std::array<size_t, kParts * kParts> counts{};
  for (int y = std::max(0, int(y0)); y < std::min(image.height, int(y1)); ++y)
    for (int x = std::max(0, int(x0)); x < std::min(image.width, int(x1)); ++x) {
      const auto part_of = [](double at, double from, double to) {
        return std::clamp(int(kParts * (at - from) / (to - from)), 0, kParts - 1);
      };
      const size_t part = size_t(kParts * part_of(y + 0.5, y0, y1) + part_of(x + 0.5, x0, x1));
      for (int c = 0; c < 3; ++c) colors[3 * part + size_t(c)] += image.at(x, y, c);
      ++counts[part];
    }
  for (size_t i = 0; i < colors.size(); ++i)
    colors[i] = counts[i / 3] > 0 ? colors[i] / float(counts[i / 3]) : kNoColor;
  return colors;
}

double FaceColorChange(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  size_t count = 0;
  for (size_t k = 0; k < a.size(); ++k) {
    if (a[k] == kNoColor || b[k] == kNoColor) continue;
    sum += std::abs(a[k] - b[k]);
    ++count;
  }
  return sum / double(std::max<size_t>(1, count));
}

std::vector<size_t> OtherLooks(const std::vector<std::vector<float>>& colors) {
  // Medians of some frames, since a hand or a flash passes.
  constexpr size_t kWindow = 5;
  constexpr double kTimesUsual = 5;
  if (colors.size() < 2 * kWindow) return {};
  const auto median = [&](size_t begin) {
    std::vector<float> medians(colors[begin].size());
    for (size_t k = 0; k < medians.size(); ++k) {
      std::array<float, kWindow> values;
      for (size_t j = 0; j < kWindow; ++j) values[j] = colors[begin + j][k];
      medians[k] = Median(values);
    }
    return medians;
  };
  std::vector<double> change(colors.size());
  for (size_t i = kWindow; i + kWindow <= colors.size(); ++i)
    change[i] = FaceColorChange(median(i), median(i - kWindow));
  std::vector<double> sorted(change.begin() + kWindow, change.end() - kWindow + 1);
  const double usual = Median(sorted);
  // The largest step within the window is where it begins.
  const auto step = [&](size_t i) { return FaceColorChange(colors[i], colors[i - 1]); };
  std::vector<size_t> places;
  for (size_t i = kWindow; i + kWindow <= colors.size(); ++i) {
    if (change[i] <= std::max(kOtherFace, kTimesUsual * usual)) continue;
    size_t at = i;
    for (; i + kWindow <= colors.size() && change[i] > kOtherFace; ++i)
      if (step(i) > step(at)) at = i;
    places.push_back(at);
  }
  return places;
}

}  // namespace cosplat
