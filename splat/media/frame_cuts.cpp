#include "splat/media/frame_cuts.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cosplat {
namespace {

constexpr int kSamples = 8;     // of a cell, across, and down
constexpr size_t kWindow = 20;  // changes, around the one that is judged
constexpr float kMinChange = 3, kTimesUsual = 5;

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
    const size_t last_from = changes_.size() - std::min(changes_.size(), kWindow + 1);
    const size_t from = std::min(i - std::min(i, kWindow / 2), last_from);
    const size_t to = std::min(from + kWindow + 1, changes_.size());
    // The second largest: there may be one other cut. Of frames that are shown several times most
    // changes are none.
    float largest = 0, usual = 0;
    for (size_t k = from; k < to; ++k) {
      if (k == i) continue;
      usual = std::max(usual, std::min(largest, changes_[k]));
      largest = std::max(largest, changes_[k]);
    }
    if (changes_[i] > std::max(kMinChange, kTimesUsual * usual)) cuts.push_back(int(i) + 1);
  }
  return cuts;
}

}  // namespace cosplat
