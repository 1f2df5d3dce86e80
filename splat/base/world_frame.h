// Where a scene's coordinates are counted from, and what its smallest lengths are measured by.
//
// Floats resolve 2^-24 of a coordinate: of a survey's (UTM, ECEF), decimetres. LoadScene therefore
// subtracts an origin near the scene in double precision, before anything becomes a float
// (splat/io/scene_place.cpp). It goes with the data: run.json -> Gaussians::origin -> splat files.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace cosplat {

// In the world of the data set, in its units: its place of a point is origin + coordinates.
using WorldOrigin = std::array<double, 3>;

// What small lengths, such as kNearPlane, are multiplied by: 1 for scenes of a size of 0.1 or more,
// since large ones have small things, too; for smaller ones the power of ten that brings the size
// to [1, 10). size > 0.
float SmallUnit(double size);

// For coordinates about `center` that differ by `spread`: zero where each is within 100 spreads of
// zero, which is all that floats are good for (fox, 1,000 steps: no loss at 300, docs/street.md);
// otherwise, for each axis that is not, a round number within half a power of ten of the centre.
WorldOrigin OriginNear(const std::array<double, 3>& center, double spread);

// The medians along the axes, and the median of the largest distance from them along any axis: what
// a few stray points do not change. points: [P, 3], any number.
struct Middle {
  std::array<double, 3> center{};
  double spread = 0;
};
Middle MiddleOf(const std::vector<double>& points);

// The same of a few thousand of `count` points, evenly chosen, where there are more; at(i): [3] of
// the i-th, of any numbers.
template <class At>
WorldOrigin OriginNearPoints(size_t count, const At& at) {
  constexpr size_t kEnough = 4096;
  std::vector<double> some;
  for (size_t i = 0; i < count; i += 1 + (count - 1) / kEnough)
    some.insert(some.end(), at(i), at(i) + 3);
  const Middle middle = MiddleOf(some);
  return OriginNear(middle.center, middle.spread);
}

// "(500120, 4600320, 0)".
std::string ToString(const WorldOrigin& origin);

}  // namespace cosplat
