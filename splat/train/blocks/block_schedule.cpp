#include "splat/train/blocks/block_schedule.h"

#include <algorithm>
#include <numeric>

namespace cosplat {
namespace {

// One step in five of a run is on the whole scene: until its images have their full size.
constexpr int64_t kShares = 5;

}  // namespace

int EndOfBlockRound(uint32_t round, int iterations, int batch) {
  const int64_t parts = iterations * int64_t(kBlockRounds + (kShares - 1) * round);
  const int64_t part = kShares * kBlockRounds * batch;
  return int(std::min<int64_t>(iterations, (parts + part - 1) / part * batch));
}

BlockGroups::BlockGroups(const std::vector<int>& work, size_t ranks)
    : ranks_(ranks), groups_(std::min(ranks, work.size())), of_block_(work.size()) {
  std::vector<size_t> order(work.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::stable_sort(
      order.begin(), order.end(), [&](size_t a, size_t b) { return work[a] > work[b]; });
  std::vector<int64_t> sums(groups_, 0);
  for (const size_t block : order) {
    const auto min = std::min_element(sums.begin(), sums.end());
    *min += work[block];
    of_block_[block] = size_t(min - sums.begin());
  }
}

}  // namespace cosplat
