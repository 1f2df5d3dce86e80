#include "splat/train/traffic.h"

namespace cosplat {
namespace {

// Of a message, as GradientSum and Shards write it.
constexpr double kWord = 4;  // bytes
constexpr double kViewLoss = sizeof(ViewLoss);

// A group with its index and, for each of its Gaussians, so many floats.
double GroupBytes(size_t floats) { return kWord * double(1 + kGaussianGroup * floats); }

}  // namespace

double TrafficOf(const ExchangeStatistics& of, size_t numbers) {
  const double others = double(of.ranks) - 1;
  const double elsewhere = others / double(of.ranks);  // share of a view that others own
  // With the gradient of the centre in the image (2) and the radius.
  const double gradients = double(of.groups_drawn) * elsewhere * GroupBytes(numbers + 3) +
                           double(of.views) * others * kViewLoss;
  const double parameters = double(of.groups_updated) * others * GroupBytes(numbers);
  constexpr size_t kStatistics = 3;
  const double statistics = double(of.assembled) * others * GroupBytes(kStatistics);
  return gradients + parameters + statistics + kWord * double(of.moments);
}

}  // namespace cosplat
