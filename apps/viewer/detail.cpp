#include "apps/viewer/detail.h"

#include <cstddef>

namespace cosplat::viewer {
namespace {

constexpr double kBudget = 50;  // ms: twenty pictures a second still follow a hand
// Of a picture with half the sides, where none was drawn yet: part of the work, posing and sorting,
// does not shrink with the pixels.
constexpr double kGuessedShare = 0.5;

}  // namespace

void Detail::Drawn(int divisor, double milliseconds) {
  milliseconds_[divisor >= 4 ? 2 : divisor >= 2 ? 1 : 0] = milliseconds;
}

int Detail::Divisor(bool dragging) const {
  if (!dragging) return 1;
  double last = 0;
  for (size_t i = 0; i + 1 < milliseconds_.size(); ++i) {
    last = milliseconds_[i] > 0 ? milliseconds_[i] : kGuessedShare * last;
    if (last <= kBudget) return 1 << i;
  }
  return 4;
}

}  // namespace cosplat::viewer
