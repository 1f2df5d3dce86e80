#include "splat/train/loss/crop_loss.h"

#include <algorithm>
#include <array>

namespace cosplat {
namespace {

constexpr int kOpaque = 128;  // alpha from which a pixel counts: half

struct Range {
  int begin, end;
};

// The ranges of columns and rows that show something.
std::array<Range, 2> Shown(const Image8& image) {
  if (image.channels != 4) return {Range{0, image.width}, Range{0, image.height}};
  Range x{image.width, 0}, y{image.height, 0};
  const uint8_t* alpha = image.data.data() + 3;
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column, alpha += 4)
      if (*alpha >= kOpaque) {
        x = {std::min(x.begin, column), std::max(x.end, column + 1)};
        y = {std::min(y.begin, row), row + 1};
      }
  if (x.end == 0) return {Range{0, image.width}, Range{0, image.height}};
  return {x, y};
}

// Where `side` of `size` pixels begin: inside the range, or around it if it is smaller.
int Begin(const Range& shown, int side, int size, Rng& rng) {
  const int a = shown.begin, b = shown.end - side;
  const int first = std::clamp(std::min(a, b), 0, size - side);
  const int last = std::clamp(std::max(a, b), 0, size - side);
  return first + int(rng.Below(uint64_t(last - first + 1)));
}

}  // namespace

Crop DrawCrop(const Image8& image, int side, Rng& rng) {
  const auto [x, y] = Shown(image);
  Crop crop{0, 0, std::min(side, image.width), std::min(side, image.height)};
  crop.x = Begin(x, crop.width, image.width, rng);
  crop.y = Begin(y, crop.height, image.height, rng);
  return crop;
}

}  // namespace cosplat
