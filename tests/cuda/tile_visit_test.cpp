// splat/render/cuda/tile_visit.cuh with counts that are not those of what is stored: two
// compilations of one test for a tile may round differently.
#include "splat/render/cuda/tile_visit.cuh"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "splat/base/rng.h"
#include "splat/config.h"
#include "splat/device/cuda/stream.h"

namespace cosplat::cuda {
namespace {

constexpr int kTiles = 20;             // across and down
constexpr uint32_t kUntouched = 4711;  // no tile, record or Gaussian

// Round splats, of which some touch a few tiles and some very many.
std::vector<ProjectedSplat> Splats(size_t count) {
  Rng rng{3};
  std::vector<ProjectedSplat> splats(count);
  for (size_t i = 0; i < count; ++i) {
    ProjectedSplat& s = splats[i];
    const float deviation = i % 3 == 0 ? 40.0f : 3.0f;  // px
    s.x = 16 * kTiles * float(rng.Uniform());
    s.y = 16 * kTiles * float(rng.Uniform());
    s.depth = 1 + float(i);
    s.opacity = 0.9f;
    s.power_xx = s.power_yy = -0.5f / (deviation * deviation);
    s.power_xy = s.x_per_y = s.y_per_x = 0;
    s.reject_below = std::log(kMinAlpha / s.opacity);
    s.half_x = s.half_y = deviation * std::sqrt(-2 * s.reject_below);
  }
  return splats;
}

struct Stored {
  std::vector<uint32_t> tiles, records, gaussians;
};

struct TileVisit : testing::Test {
  static constexpr size_t kCount = 100;
  CudaStream stream;
  Buffer<ProjectedSplat> splats;
  KeyedValues by_depth;

  TileVisit() {
    const std::vector<ProjectedSplat> all = Splats(kCount);
    splats.Upload(all.data(), all.size(), stream);
    by_depth.Refill(kCount, stream);
    std::vector<uint32_t> order(kCount);
    std::iota(order.begin(), order.end(), 0u);
    by_depth.keys.Upload(order.data(), order.size(), stream);
    by_depth.values.Upload(order.data(), order.size(), stream);
  }
  TileVisitor Visitor() {
    return VisitorOf(std::as_const(splats).view(), by_depth, kTiles, kTiles);
  }
  std::vector<uint64_t> Count() {
    Buffer<uint64_t> counts, visible;
    counts.Refill(kCount + 1, stream);
    visible.Refill(1, stream);
    ForBlocks(1, stream, CountTiles{Visitor(), counts.view(), visible.data()});
    std::vector<uint64_t> n(kCount + 1);
    counts.Download(n.data(), stream);
    stream.Wait();
    return n;
  }
  Stored Emit(const std::vector<uint64_t>& counts) {
    std::vector<uint64_t> begin(kCount + 1, 0);
    std::partial_sum(counts.begin(), counts.end() - 1, begin.begin() + 1);
    const size_t instances = begin.back();
    Buffer<uint64_t> record_begin, total;
    total.Refill(1, stream);
    record_begin.Upload(begin.data(), begin.size(), stream);
    const std::vector<uint32_t> untouched(instances, kUntouched);
    Buffer<uint32_t> tiles, records, of_record;
    for (Buffer<uint32_t>* b : {&tiles, &records, &of_record})
      b->Upload(untouched.data(), instances, stream);
    ForBlocks(1,
              stream,
              EmitInstances{Visitor(),
                            std::as_const(record_begin).view(),
                            kTiles * kTiles,
                            tiles.view(),
                            records.view(),
                            of_record.view(),
                            total.data(),
                            nullptr});
    Stored stored{untouched, untouched, untouched};
    tiles.Download(stored.tiles.data(), stream);
    records.Download(stored.records.data(), stream);
    of_record.Download(stored.gaussians.data(), stream);
    stream.Wait();
    return stored;
  }
};

TEST_F(TileVisit, ACountThatIsWrongWritesNothingElsewhere) {
  const std::vector<uint64_t> counted = Count();
  ASSERT_GT(*std::max_element(counted.begin(), counted.end()), 100u);
  const Stored right = Emit(counted);
  for (const int wrong : {-1, 1, 3}) {
    std::vector<uint64_t> counts = counted;
    for (size_t k = 0; k < kCount; k += 2)
      counts[k] = uint64_t(std::max<int64_t>(0, int64_t(counts[k]) + wrong));
    const Stored stored = Emit(counts);
    size_t r = 0, of_right = 0;
    for (size_t k = 0; k < kCount; ++k) {
      for (uint64_t n = 0; n < counts[k]; ++n, ++r) {
        ASSERT_EQ(stored.records[r], r);
        ASSERT_EQ(stored.gaussians[r], k);
        // Those beyond what is touched sort behind the last tile.
        ASSERT_EQ(stored.tiles[r], n < counted[k] ? right.tiles[of_right + n] : kTiles * kTiles)
            << k << " " << n;
      }
      of_right += counted[k];
    }
    EXPECT_EQ(r, stored.tiles.size());
  }
}

}  // namespace
}  // namespace cosplat::cuda
