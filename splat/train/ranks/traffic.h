// What the ranks of a training send, calculated: for docs/large-scenes.md and tests/scale/model,
// and against what Ranks::bytes_sent counts.
#pragma once

#include <cstddef>

#include "splat/train/step_engine.h"

namespace cosplat {

// Bytes, over all ranks. of: counts of groups, numbers and views. A rank owns an even share of the
// groups that a view draws, as it nearly does (splat/train/row_share.h).
double TrafficOf(const ExchangeStatistics& of);

}  // namespace cosplat
