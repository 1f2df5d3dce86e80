#include "splat/media/still_background.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "splat/base/median.h"
#include "splat/media/image_filters.h"

namespace cosplat {
namespace {

constexpr float kMinNoise = 1.5f / 255;  // of 8 bits and a codec
// A background that moves by half a pixel changes more than this where it shows anything.
constexpr float kMaxNoise = 7.f / 255;
// Frames that must show a pixel of the background, of all, and at least.
constexpr float kMinShare = 0.08f;
constexpr size_t kMinFrames = 4;

// What the eight bits of something at rest differ by in most frames, as a codec leaves them, and
// what its edges do.
constexpr int kStillRange = 7, kStillEdge = 12;
// The network takes a thing for the person in some frames; less than kHesitates in a tenth of them.
constexpr uint8_t kPerson = 25, kHesitates = 205;

// Of the values without the tenth at each end.
struct Range {
  uint8_t low, high;
};
Range RangeOf(std::vector<uint8_t>& values) {
  const size_t tenth = values.size() / 10;
  std::sort(values.begin(), values.end());
  return {values[tenth], values[values.size() - 1 - tenth]};
}

// Of a mask of 0 and 1, what squares of 2 radius + 1 px fit into.
Image Opened(const Image& mask, int radius) {
  Image result = BoxMean(mask, radius);
  for (float& mean : result.data) mean = mean > 0.999f ? 1.f : 0.f;
  return Dilated(result, radius);
}

}  // namespace

Image8 FindStillThings(const std::vector<Image8>& frames,
                       const std::vector<Image8>& mattes,
                       int radius) {
  const int width = frames.at(0).width, height = frames[0].height;
  Image unsure(width, height, 1), rest(width, height, 1), person(width, height, 1);
  tbb::parallel_for(0, height, [&](int y) {
    std::vector<uint8_t> values(frames.size());
    for (size_t i = size_t(y) * size_t(width); i < size_t(y + 1) * size_t(width); ++i) {
      for (size_t f = 0; f < frames.size(); ++f) values[f] = mattes[f].data[i];
      const Range matte = RangeOf(values);
      if (matte.high < kPerson) continue;
      person.data[i] = 1;
      int range = 0;
      for (size_t c = 0; c < 3; ++c) {
        for (size_t f = 0; f < frames.size(); ++f) values[f] = frames[f].data[3 * i + c];
        const Range color = RangeOf(values);
        range = std::max(range, color.high - color.low);
      }
      unsure.data[i] = range <= kStillRange && matte.low < kHesitates ? 1.f : 0.f;
      rest.data[i] = range <= kStillEdge ? 1.f : 0.f;
    }
  });
  unsure = BoxMean(unsure, 2);
  for (float& share : unsure.data) share = share > 0.5f ? 1.f : 0.f;
  const Image found = Opened(unsure, radius);
  Image8 things(width, height, 1);
  for (int y = 0; y < height; ++y) {
    int covered = 0, all = 0;
    for (int x = 0; x < width; ++x) covered += found.at(x, y, 0) > 0, all += person.at(x, y, 0) > 0;
    const bool whole = 2 * covered > all;
    for (int x = 0; x < width; ++x)
      things.at(x, y, 0) = found.at(x, y, 0) > 0 || (whole && rest.at(x, y, 0) > 0);
  }
  return things;
}

StillBackground FindStillBackground(const std::vector<Image8>& frames,
                                    const std::vector<Image8>& clear) {
  const int width = frames.at(0).width, height = frames[0].height;
  StillBackground found{Image(width, height, 3), Image(width, height, 1, -1)};
  const size_t needed = std::max(kMinFrames, size_t(std::ceil(kMinShare * float(frames.size()))));
  tbb::parallel_for(0, height, [&](int y) {
    std::vector<size_t> seen;
    std::vector<float> values;
    for (size_t i = size_t(y) * size_t(width); i < size_t(y + 1) * size_t(width); ++i) {
      seen.clear();
      for (size_t f = 0; f < frames.size(); ++f)
        if (clear[f].data[i] != 0) seen.push_back(f);
      if (seen.size() < needed) continue;
      float noise = kMinNoise;
      for (size_t c = 0; c < 3; ++c) {
        values.clear();
        for (const size_t f : seen) values.push_back(float(frames[f].data[3 * i + c]) / 255);
        const float median = Median(values);
        found.color.data[3 * i + c] = median;
        for (float& value : values) value = std::abs(value - median);
        noise = std::max(noise, 1.4826f * Median(values));  // of a normal distribution
      }
      if (noise <= kMaxNoise) found.noise.data[i] = noise;
    }
  });
  return found;
}

}  // namespace cosplat
