// The blend loop over one tile, on the widest SIMD instruction set of the machine.
#pragma once

#include <cstdint>

#include "splat/config.h"
#include "splat/render/contribution.h"
#include "splat/render/cpu/tile_lists.h"

namespace cosplat {

struct TileJob {
  const ProjectedSplat* splats = nullptr;
  const TileEntry* entries = nullptr;  // this tile's, front to back
  uint32_t entry_count = 0;
  int x0 = 0, y0 = 0;         // the tile's first pixel
  int width = 0, height = 0;  // of the image
  float background[3] = {0, 0, 0};
  int exp_degree = kMaxExpDegree;  // the same forward and backward
  float* color = nullptr;          // [3, height, width]
  float* transmittance = nullptr;  // [height, width]
};

// Writes the tile's pixels. Returns how many entries were looked at before every pixel was opaque.
uint32_t BlendTileForward(const TileJob& job);

// d_color: [3, height, width]. Writes records[entry.record] for each of the job's entries (the
// caller passes only those that the forward pass looked at).
void BlendTileBackward(const TileJob& job, const float* d_color, SplatGradient* records);

// What each splat of a tile contributes to its pixels: the scores of pruning
// (splat/train/importance.h).

// Writes records[entry.record] for each of the job's entries (the caller passes only those that the
// forward pass looked at; job.color must be what it wrote).
void SumContributions(const TileJob& job, Contribution* records);

}  // namespace cosplat
