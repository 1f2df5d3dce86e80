// What ranks are to send, calculated.
#pragma once

#include "splat/train/loss/photograph.h"
#include "splat/train/ranks/view_exchange.h"

namespace cosplat {

// Bytes, over all ranks: for docs/large-scenes.md and tests/scale/model, and against what
// Ranks::bytes_sent counts. of: counts of groups, numbers and views. A rank owns an even share of
// the groups that a view draws, as it nearly does (splat/train/ranks/row_share.h).
inline double TrafficOf(const ExchangeStatistics& of) {
  constexpr double kWord = 4;  // bytes
  // As ViewExchange sends it of a group that a view shows: its index, its splats with their radii;
  // and the gradients that come back.
  constexpr double kGroup =
      kWord + double(kGaussianGroup) *
                  double(kProjectedStride * sizeof(float) + sizeof(float) + sizeof(SplatGradient));
  // What every rank is told of a view: loss and gradient of the exposure.
  constexpr double kView = sizeof(double) + sizeof(Exposure);
  const double others = double(of.ranks) - 1;
  const double elsewhere = others / double(of.ranks);  // share of a view that others own
  return double(of.groups_drawn) * elsewhere * kGroup + double(of.views) * others * kView +
         kWord * double(of.assembled) * others + kWord * double(of.handed_over);
}

}  // namespace cosplat
