// The blend loop over one tile, dispatched to the widest SIMD instruction set of the machine.
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
  // [entry_count] where in the tile each was blended, a bit for a pack or 8 pixels: the forward
  // pass writes it, the backward pass reads it.
  uint32_t* blended = nullptr;
  int x0 = 0, y0 = 0;         // the tile's first pixel
  int width = 0, height = 0;  // of the image
  float background[3] = {0, 0, 0};
  int exp_degree = kMaxExpDegree;  // must be the same in the forward and backward passes
  float* color = nullptr;          // [3, height, width]
  float* transmittance = nullptr;  // [height, width]
};

// Writes the tile's pixels. Returns the number of entries processed before every pixel was opaque.
uint32_t BlendTileForward(const TileJob& job);

// d_color: [3, height, width]. Writes records[entry.record] for each of the job's entries (the
// caller passes only those that the forward pass processed).
void BlendTileBackward(const TileJob& job, const float* d_color, SplatGradient* records);

// Sums each splat's contributions to the tile's pixels, the basis of pruning scores
// (splat/train/prune/importance.h). Writes records[entry.record] for each of the job's entries (the
// caller passes only those that the forward pass processed; job.color must be what it wrote).
void SumContributions(const TileJob& job, Contribution* records);

}  // namespace cosplat
