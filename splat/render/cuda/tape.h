// What the device keeps from a forward pass, for Backward and for queries about what was rendered.
#pragma once

#include <vector>

#include "splat/device/buffer.h"
#include "splat/render/contribution.h"
#include "splat/render/cuda/tile_lists.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/render/rasterizer.h"

namespace cosplat::cuda {

// How a Gaussian's gradients from its tiles are summed: with atomics, in arbitrary order, so that
// the last bits differ from run to run; or in a fixed order, through one record per instance.
enum class SumOrder { kAny, kFixed };

// A pixel's state before a bucket: transmittance and accumulated colour.
using PixelCheckpoint = float4;

struct CudaTape : RenderTape {
  CudaTape(bool kept, SumOrder order) : kept(kept), order(order) {}

  const InstanceCounts* counts() const override { return lists.counts(); }
  std::vector<MemoryPart> Memory() const override;
  // Queries the driver for free memory only if the tape would have to grow.
  bool Expect(size_t instances, uint32_t* exceeded) override;
  size_t capacity() const override { return lists.capacity(); }

  bool kept;  // whether to keep what Backward and Contributions need
  SumOrder order;
  ViewParameters view{};
  RenderSettings settings;
  TileLists lists;
  Buffer<uint32_t> n_contrib;           // [tiles] instances processed before the tile was opaque
  Buffer<PixelCheckpoint> checkpoints;  // [buckets, pixels of a tile]
  Buffer<SplatGradient> records;        // [capacity of the lists]; only with SumOrder::kFixed
  Buffer<Contribution> contributions;   // [capacity]; allocated on first use
};

// Blends tape.lists into the image, with one block per tile; if tape.kept, also stores what
// BlendBackward needs.
void BlendForward(CudaTape& tape, RenderedImage& image, Stream& stream);

// Fills tape.d_splats, with 0 for invisible Gaussians; one warp per bucket.
// d_color: [3, height, width] on the device.
void BlendBackward(CudaTape& tape,
                   const RenderedImage& image,
                   const float* d_color,
                   Stream& stream);

// contributions: [count] on the device, overwritten. Summed in a fixed order.
void SumContributions(CudaTape& tape,
                      const RenderedImage& image,
                      Contribution* contributions,
                      Stream& stream);

}  // namespace cosplat::cuda
