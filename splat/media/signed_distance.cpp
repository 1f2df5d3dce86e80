#include "splat/media/signed_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace cosplat {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

// out[x] = min over i of (x - i)^2 + f[i]: the lower envelope of parabolas (Felzenszwalb &
// Huttenlocher, Distance transforms of sampled functions, 2012, algorithm 1). Some f are finite.
class Envelope {
 public:
  explicit Envelope(size_t count) : apexes_(count), begins_(count) {}

  void Lower(const std::vector<float>& f, std::vector<float>& out) {
    size_t count = 0;
    for (size_t i = 0; i < f.size(); ++i) {
      if (f[i] == kFar) continue;
      double begin = -std::numeric_limits<double>::infinity();
      for (; count > 0; --count) {
        begin = Crossing(f, apexes_[count - 1], i);
        if (begin > begins_[count - 1]) break;
        begin = -std::numeric_limits<double>::infinity();
      }
      apexes_[count] = i;
      begins_[count++] = begin;
    }
    for (size_t x = 0, k = 0; x < f.size(); ++x) {
      while (k + 1 < count && begins_[k + 1] < double(x)) ++k;
      const float d = float(x) - float(apexes_[k]);
      out[x] = d * d + f[apexes_[k]];
    }
  }

 private:
  // From where on the parabola of i is below that of k < i.
  static double Crossing(const std::vector<float>& f, size_t k, size_t i) {
    const double of_k = double(k), of_i = double(i);
    return (double(f[i]) + of_i * of_i - double(f[k]) - of_k * of_k) / (2 * (of_i - of_k));
  }

  std::vector<size_t> apexes_;
  std::vector<double> begins_;  // from where on a parabola is the lowest
};

// [height, width] squared px to the nearest pixel with in[pixel] == value; infinite if there is
// none.
std::vector<float> SquaredDistance(const std::vector<uint8_t>& in,
                                   uint8_t value,
                                   size_t width,
                                   size_t height) {
  std::vector<float> squared(width * height, kFar);
  // Down and up all columns, then along rows.
  std::vector<float> steps(width, kFar);  // from the last such pixel of each column
  const auto visit = [&](size_t y) {
    for (size_t x = 0; x < width; ++x) {
      steps[x] = in[y * width + x] == value ? 0 : steps[x] + 1;
      float& s = squared[y * width + x];
      s = std::min(s, steps[x] * steps[x]);
    }
  };
  for (size_t y = 0; y < height; ++y) visit(y);
  std::fill(steps.begin(), steps.end(), kFar);
  for (size_t y = height; y-- > 0;) visit(y);
  Envelope envelope(width);
  std::vector<float> row(width), lowest(width);
  for (size_t y = 0; y < height; ++y) {
    bool some = false;
    for (size_t x = 0; x < width; ++x) {
      row[x] = squared[y * width + x];
      some = some || row[x] != kFar;
    }
    if (!some) continue;
    envelope.Lower(row, lowest);
    std::copy(lowest.begin(), lowest.end(), squared.begin() + std::ptrdiff_t(y * width));
  }
  return squared;
}

}  // namespace

Image SignedDistance(const Image8& mask, uint8_t threshold) {
  const size_t width = size_t(mask.width), height = size_t(mask.height);
  std::vector<uint8_t> inside(mask.pixels());
  for (size_t i = 0; i < mask.pixels(); ++i) inside[i] = mask.data[i] >= threshold;
  const std::vector<float> to_inside = SquaredDistance(inside, 1, width, height);
  const std::vector<float> to_outside = SquaredDistance(inside, 0, width, height);
  Image out(mask.width, mask.height, 1);
  for (size_t i = 0; i < mask.pixels(); ++i)
    out.data[i] = inside[i] ? 0.5f - std::sqrt(to_outside[i]) : std::sqrt(to_inside[i]) - 0.5f;
  return out;
}

}  // namespace cosplat
