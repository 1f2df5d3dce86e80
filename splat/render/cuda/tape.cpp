#include "splat/render/cuda/tape.h"

#include "splat/config.h"
#include "splat/render/cuda/rasterizer.h"

namespace cosplat::cuda {
namespace {

constexpr double kGrowth = 1 + 1.0 / kHeadRoom;  // growth of a Buffer
// Bytes per Gaussian: the projected splat with its radius and gradient, and the sort by depth.
constexpr double kPerSplat = sizeof(ProjectedSplat) + sizeof(float) + sizeof(SplatGradient) +
                             4 * sizeof(uint32_t) + sizeof(uint64_t);
// Bytes per instance: two pairs of keys and values, the Gaussian by record and by list entry, and
// its share of a bucket's pixels.
constexpr double kPerInstance =
    6 * sizeof(uint32_t) + double(kTileSize) * kTileSize * sizeof(PixelCheckpoint) / kBucket;

double BytesPerInstance(SumOrder order) {
  return kPerInstance + (order == SumOrder::kFixed ? sizeof(SplatGradient) : 0);
}

}  // namespace

double CudaRasterizer::BytesPerGaussian(double instances) const {
  return kPerSplat + instances * BytesPerInstance(order_);
}

bool CudaTape::Expect(size_t instances, uint32_t* exceeded) {
  if (instances > lists.allocated()) {
    // A tile's last bucket may be nearly empty.
    const double partial = double(lists.tiles()) * kTileSize * kTileSize;
    const double wanted =
        kGrowth * (double(instances) * BytesPerInstance(order) + partial * sizeof(PixelCheckpoint));
    const size_t held = lists.InstanceBytes() + AllocatedBytes(checkpoints, records);
    if (wanted > double(held) + kUsableMemory * double(FreeMemory())) return false;
  }
  lists.Expect(instances, exceeded);
  return true;
}

std::vector<MemoryPart> CudaTape::Memory() const {
  return {{"projected splats", AllocatedBytes(splats, radius)},
          {"tile lists", lists.GaussianBytes()},
          {"gradients per splat and tile", AllocatedBytes(records, contributions)},
          {"gradients per splat", AllocatedBytes(d_splats)},
          {"pixels per bucket of splats", AllocatedBytes(checkpoints)},
          {"tiles", lists.TileBytes() + AllocatedBytes(n_contrib), MemoryOf::kPixels}};
}

}  // namespace cosplat::cuda
