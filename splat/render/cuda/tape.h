// What the device keeps of a drawing: for Backward and for whoever asks what was drawn.
#pragma once

#include <vector>

#include "splat/device/buffer.h"
#include "splat/render/contribution.h"
#include "splat/render/cuda/tile_lists.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/render/rasterizer.h"

namespace cosplat::cuda {

// How a Gaussian's parts from its tiles are added up: as they come, by atomics, so that the last
// bits differ from run to run; or in a fixed order, by way of a record for each instance.
enum class SumOrder { kAny, kFixed };

// A pixel as it was before a bucket: transmittance and colour so far.
using PixelCheckpoint = float4;

struct CudaTape : RenderTape {
  CudaTape(bool kept, SumOrder order) : kept(kept), order(order) {}

  View<const float> radii() const override { return radius.view(); }
  const InstanceCounts* counts() const override { return lists.counts(); }
  std::vector<MemoryPart> Memory() const override;
  // The driver is asked how much is free only where the tape would have to grow.
  bool Expect(size_t instances, uint32_t* exceeded) override;
  size_t capacity() const override { return lists.capacity(); }

  bool kept;  // for Backward
  SumOrder order;
  ViewParameters view{};
  RenderSettings settings;
  Buffer<ProjectedSplat> splats;  // [count]
  Buffer<float> radius;           // [count]
  TileLists lists;
  Buffer<uint32_t> n_contrib;           // [tiles] instances before the tile was opaque
  Buffer<PixelCheckpoint> checkpoints;  // [buckets, pixels of a tile]
  Buffer<SplatGradient> records;        // [capacity of the lists]; SumOrder::kFixed alone
  Buffer<SplatGradient> d_splats;       // [count]
  Buffer<Contribution> contributions;   // [capacity]; only once they were asked for
};

// A tile's instances, front to back -> image, and back: a block per tile, or a warp per bucket.

// Draws tape.lists into the image; with tape.kept also what BlendBackward needs.
void BlendForward(CudaTape& tape, RenderedImage& image, Stream& stream);

// Fills tape.d_splats, 0 where nothing was drawn. d_color: [3, height, width] on the device.
void BlendBackward(CudaTape& tape,
                   const RenderedImage& image,
                   const float* d_color,
                   Stream& stream);

// contributions: [count] on the device, overwritten. In a fixed order.
void SumContributions(CudaTape& tape,
                      const RenderedImage& image,
                      Contribution* contributions,
                      Stream& stream);

}  // namespace cosplat::cuda
