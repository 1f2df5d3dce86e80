// What each splat of a tile contributes to its pixels: the scores of pruning
// (splat/train/importance.h).
#pragma once

#include "splat/render/contribution.h"
#include "splat/render/cpu/blend_tile.h"

namespace cosplat {

// Writes records[entry.record] for each of the job's entries (the caller passes only those that the
// forward pass looked at; job.color must be what it wrote).
void SumContributions(const TileJob& job, Contribution* records);

}  // namespace cosplat
