// Sorting and adding up on the device.
#include "splat/device/sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "splat/base/rng.h"
#include "splat/device/cuda/stream.h"
#include "splat/device/sum_tree.h"
#include "splat/render/kernels/tile_range.h"
#include "splat/train/cuda/kernels.h"
#include "tests/parity/device_fixture.h"

namespace cosplat::cuda {
namespace {

class DeviceSort : public test::DeviceTest {};

TEST_F(DeviceSort, IsStableAndSeesTheLowestBitsAlone) {
  CudaStream stream;
  KeyedValues pairs;
  for (const size_t n : {size_t(0), size_t(1), size_t(33), size_t(5000)}) {
    Rng rng{n};
    std::vector<uint32_t> keys(n), values(n), order(n);
    for (uint32_t& k : keys) k = uint32_t(rng.Below(40)) | uint32_t(rng.Below(2)) << 30;
    std::iota(values.begin(), values.end(), 7u);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
      return keys[a] % 64 < keys[b] % 64;
    });
    pairs.Refill(n, stream);
    pairs.keys.Upload(keys.data(), n, stream);
    pairs.values.Upload(values.data(), n, stream);
    stream.Sort(pairs, 6);
    std::vector<uint32_t> sorted(n);
    pairs.values.Download(sorted.data(), stream);
    stream.Wait();
    for (size_t i = 0; i < n; ++i) EXPECT_EQ(sorted[i], values[order[i]]) << i << " of " << n;
  }
}

// Counts of instances are added as 64 bits: 2^32 does not wrap to something that looks possible.
TEST_F(DeviceSort, SumsDoNotWrapAt32Bits) {
  CudaStream stream;
  Buffer<uint64_t> numbers;
  const uint64_t large = uint64_t(1) << 31;
  const std::vector<uint64_t> counts{large, large, 5, large, 0};
  numbers.Upload(counts.data(), counts.size(), stream);
  stream.ExclusiveSum(numbers);
  std::vector<uint64_t> sums(counts.size());
  numbers.Download(sums.data(), stream);
  stream.Wait();
  EXPECT_EQ(sums, (std::vector<uint64_t>{0, large, 2 * large, 2 * large + 5, 3 * large + 5}));
  EXPECT_EQ((math::TileRange{0, 70000, 0, 70000}.size()), uint64_t(70000) * 70000);
}

// A tree of doubles has the host's bits.
TEST_F(DeviceSort, TreesOfSumsHaveTheHostsBits) {
  ProvideTrainKernels();
  CudaStream stream;
  for (const size_t n : {size_t(0), size_t(1), kSumBlock, kSumBlock * kSumBlock + 1}) {
    Rng rng{n};
    Buffer<double> values(n), on_device, of_host, of_device;
    for (double& v : values) v = rng.Uniform() - 0.5;
    on_device.Upload(values.data(), n, stream);
    const auto host = SumInTree(View<const double>(values), of_host, HostStream());
    const auto device = SumInTree(View<const double>(on_device), of_device, stream);
    ASSERT_EQ(device.count, host.count);
    EXPECT_LE(host.count, kSumBlock);
    std::vector<double> sums(device.count);
    stream.Download(sums.data(), device.data, device.count * sizeof(double));
    stream.Wait();
    EXPECT_EQ(sums, std::vector<double>(host.begin(), host.end())) << n;
    const double total = std::accumulate(values.begin(), values.end(), 0.0);
    EXPECT_NEAR(SumOfBlock(host, 0), total, 1e-12 * double(n)) << n;
  }
}

}  // namespace
}  // namespace cosplat::cuda
