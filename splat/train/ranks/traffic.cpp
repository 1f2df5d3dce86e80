#include "splat/train/ranks/traffic.h"

#include "splat/render/kernels/projected_splat.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/loss/photograph.h"

namespace cosplat {
namespace {

constexpr double kWord = 4;  // bytes
// As ViewExchange sends it of a group that a view shows: its index, its splats with their radii;
// and the gradients that come back.
constexpr double kGroup =
    kWord + double(kGaussianGroup) *
                double(kProjectedStride * sizeof(float) + sizeof(float) + sizeof(SplatGradient));
// What every rank is told of a view: loss and gradient of the exposure.
constexpr double kView = sizeof(double) + sizeof(Exposure);

}  // namespace

double TrafficOf(const ExchangeStatistics& of) {
  const double others = double(of.ranks) - 1;
  const double elsewhere = others / double(of.ranks);  // share of a view that others own
  return double(of.groups_drawn) * elsewhere * kGroup + double(of.views) * others * kView +
         kWord * double(of.assembled) * others + kWord * double(of.handed_over);
}

}  // namespace cosplat
