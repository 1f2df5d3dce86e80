// Where is a video cut from one shot to another?
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cosplat {

// Where a frame's brightness is in memory: in one plane, row by row.
struct BrightnessPlane {
  const uint8_t* data = nullptr;
  ptrdiff_t row = 0;  // bytes
  int step = 1;       // bytes per pixel
  int bits = 8;       // the value's; of more than 8 in two bytes
  int shift = 0;      // that it is stored higher
  int width = 0, height = 0;
};

// Frames are given in order. A cut is where the picture changes several times as much as from any
// frame around it to the next, but one: what moves, changes there, too. A sudden light, a title
// that appears count as cuts; one picture that fades into another does not.
class CutFinder {
 public:
  void Add(const BrightnessPlane& plane);
  // The frames that begin another shot, increasing.
  std::vector<int> Cuts() const;

 private:
  static constexpr int kCells = 32;  // across, and down
  using Cells = std::array<float, kCells * kCells>;

  bool begun_ = false;
  Cells last_{};
  std::vector<float> changes_;  // from frame i to i + 1, 8-bit levels
};

}  // namespace cosplat
