#include "splat/train/cuda/device_memory.h"

#include <cstdio>

#include "splat/render/cuda/tape.h"

namespace cosplat::cuda {
namespace {

constexpr double kUsable = 0.9;                  // of what is free: allocators do not get all of it
constexpr double kGrowth = 1 + 1.0 / kHeadRoom;  // DeviceBuffer

// Beside parameters, gradients and moments: four statistics and one in turn, the screen's gradient,
// the projected splat with its radius and gradient, sorting by depth, and density control.
constexpr double kBesideParameters =
    5 * sizeof(float) + 2 * sizeof(float) + sizeof(ProjectedSplat) + sizeof(float) +
    sizeof(SplatGradient) + 4 * sizeof(uint32_t) + sizeof(uint64_t) + 4 * sizeof(uint64_t) +
    6 * sizeof(uint32_t) + 2 * sizeof(uint8_t) + 3 * sizeof(float);
// Lists: two pairs of keys and values, the record's Gaussian, the list's; and a bucket's pixels.
constexpr double kPerInstance =
    6 * sizeof(uint32_t) + double(kTileSize) * kTileSize * sizeof(PixelCheckpoint) / kBucket;

double BytesPerInstance(SumOrder order) {
  return kPerInstance + (order == SumOrder::kFixed ? sizeof(SplatGradient) : 0);
}

}  // namespace

size_t FreeMemory() {
  size_t free = 0, total = 0;
  Check(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  return free;
}

size_t Footprint::MostThatFit(size_t held, size_t free) const {
  return size_t((double(held) + kUsable * double(free)) / (kGrowth * per_gaussian));
}

Footprint FootprintOf(const DeviceGaussians& gaussians,
                      SumOrder order,
                      double instances_per_gaussian) {
  size_t numbers = 0;
  for (int a = 0; a < kAttributeCount; ++a) numbers += size_t(gaussians.width(a));
  return {4 * sizeof(float) * double(numbers) + kBesideParameters +
          instances_per_gaussian * BytesPerInstance(order)};
}

bool HasCapacityFor(size_t instances, SumOrder order, const Tape& tape) {
  if (instances <= tape.lists.allocated()) return true;
  // A tile's last bucket may be nearly empty.
  const double partial = double(tape.lists.tiles()) * kTileSize * kTileSize;
  const double wanted =
      kGrowth * (double(instances) * BytesPerInstance(order) + partial * sizeof(PixelCheckpoint));
  const size_t held = tape.lists.HeldForInstances() + HeldBy(tape.checkpoints, tape.records);
  return wanted <= double(held) + kUsable * double(FreeMemory());
}

std::string NoticeOfMemory(size_t gaussians) {
  size_t free = 0, total = 0;
  Check(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  char text[160];
  std::snprintf(text,
                sizeof text,
                "the device's memory is nearly full (%.2f of %.2f GB are free): training goes on "
                "with about %zu Gaussians",
                1e-9 * double(free),
                1e-9 * double(total),
                gaussians);
  return text;
}

}  // namespace cosplat::cuda
