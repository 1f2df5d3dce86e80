#include "splat/media/frame_cuts.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cosplat {
namespace {

constexpr int kSamples = 8;    // of a cell, across, and down
constexpr size_t kWindow = 6;  // frames to either side
constexpr float kMinChange = 3, kTimesUsual = 4;

float BrightnessAt(const BrightnessPlane& plane, int x, int y) {
  const uint8_t* const at = plane.data + y * plane.row + x * plane.step;
  if (plane.bits <= 8) return float(*at >> plane.shift);
  uint16_t value;
  std::memcpy(&value, at, sizeof(value));
  return float(value >> plane.shift) / float(1 << (plane.bits - 8));
}

}  // namespace

void CutFinder::Add(const BrightnessPlane& plane) {
  Cells cells{};
  constexpr int kAcross = kCells * kSamples;
  for (int j = 0; j < kAcross; ++j)
    for (int i = 0; i < kAcross; ++i)
      cells[size_t(j / kSamples * kCells + i / kSamples)] +=
          BrightnessAt(plane,
                       int(int64_t(i) * plane.width / kAcross),
                       int(int64_t(j) * plane.height / kAcross)) /
          (kSamples * kSamples);
  if (begun_) {
    float change = 0;
    for (size_t k = 0; k < cells.size(); ++k) change += std::abs(cells[k] - last_[k]);
    changes_.push_back(change / float(cells.size()));
  }
  begun_ = true;
  last_ = cells;
}

std::vector<int> CutFinder::Cuts() const {
  std::vector<int> cuts;
  for (size_t i = 0; i < changes_.size(); ++i) {
    const size_t from = i - std::min(i, kWindow), to = std::min(i + kWindow + 1, changes_.size());
    float others = 0;
    for (size_t k = from; k < to; ++k) others += k == i ? 0 : changes_[k];
    others /= float(std::max<size_t>(1, to - from - 1));
    if (changes_[i] > std::max(kMinChange, kTimesUsual * others)) cuts.push_back(int(i) + 1);
  }
  return cuts;
}

}  // namespace cosplat
