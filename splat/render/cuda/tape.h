// What the device keeps of a drawing: for Backward and for whoever asks what was drawn.
#pragma once

#include <vector>

#include "splat/device/memory_part.h"
#include "splat/render/contribution.h"
#include "splat/render/cuda/tile_lists.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/render/rasterizer.h"

namespace cosplat::cuda {

struct DeviceImage {
  int width = 0, height = 0;
  DeviceBuffer<float> color;          // [3, height, width]
  DeviceBuffer<float> transmittance;  // [height, width]
};

// A pixel as it was before a bucket: transmittance and colour so far.
using PixelCheckpoint = float4;

// Reuse one for many steps: it keeps its memory.
struct Tape {
  ViewParameters view{};
  RenderSettings settings;
  bool kept = false;                    // for Backward
  DeviceBuffer<ProjectedSplat> splats;  // [count]
  DeviceBuffer<float> radii;            // [count]
  TileLists lists;
  DeviceBuffer<uint32_t> n_contrib;           // [tiles] instances before the tile was opaque
  DeviceBuffer<PixelCheckpoint> checkpoints;  // [buckets, pixels of a tile]
  DeviceBuffer<SplatGradient> records;        // [capacity of the lists]; deterministic mode alone
  DeviceBuffer<SplatGradient> d_splats;       // [count]
  DeviceBuffer<Contribution> contributions;   // [capacity]; only once they were asked for

  std::vector<MemoryPart> Memory() const;
};

}  // namespace cosplat::cuda
