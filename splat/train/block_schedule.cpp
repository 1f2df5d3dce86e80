#include "splat/train/block_schedule.h"

#include <algorithm>
#include <iterator>

namespace cosplat {
namespace {

// One step in five of a run is on the whole scene: until its images have their full size.
constexpr int64_t kShares = 5;
// Of the views of the block with fewer, that two blocks of one turn have in common.
constexpr double kMaxSharedViews = 0.1;
// Where blocks are trained at once, which takes them longer to agree.
constexpr uint32_t kRoundsAtOnce = 4;

bool ShareViews(const std::vector<uint32_t>& a, const std::vector<uint32_t>& b) {
  std::vector<uint32_t> both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return double(both.size()) > kMaxSharedViews * double(std::min(a.size(), b.size()));
}

}  // namespace

// The least crowded of the turns that a block can have, or a new one (greedy graph colouring).
BlockSchedule::BlockSchedule(const std::vector<std::vector<uint32_t>>& views) {
  for (uint32_t block = 0; block < views.size(); ++block) {
    std::vector<uint32_t>* best = nullptr;
    for (auto& turn : blocks_) {
      const bool fits = std::none_of(turn.begin(), turn.end(), [&](uint32_t other) {
        return ShareViews(views[block], views[other]);
      });
      if (fits && (!best || turn.size() < best->size())) best = &turn;
    }
    if (!best) best = &blocks_.emplace_back();
    best->push_back(block);
  }
  if (at_once() > 1) rounds_ = kRoundsAtOnce;
}

int BlockSchedule::EndOfRound(uint32_t round, int iterations, int batch) const {
  const int64_t parts = iterations * int64_t(rounds_ + (kShares - 1) * round);
  const int64_t part = kShares * rounds_ * batch;
  return int(std::min<int64_t>(iterations, (parts + part - 1) / part * batch));
}

uint32_t BlockSchedule::RoundOf(uint32_t turn) const {
  return turn == 0 ? 0 : 1 + (turn - 1) / turns_of_round();
}

const std::vector<uint32_t>& BlockSchedule::BlocksOf(uint32_t turn) const {
  return blocks_[(turn - 1) % turns_of_round()];
}

size_t BlockSchedule::at_once() const {
  size_t most = 0;
  for (const auto& turn : blocks_) most = std::max(most, turn.size());
  return most;
}

BlockGroups::BlockGroups(const BlockSchedule& schedule,
                         const std::vector<int>& work,
                         size_t ranks,
                         int batch)
    : groups_(std::min(ranks, schedule.at_once())),
      working_(std::min(ranks, groups_ * size_t(batch))),
      of_block_(work.size()) {
  for (uint32_t turn = 1; turn <= schedule.turns_of_round(); ++turn) {
    std::vector<uint32_t> order = schedule.BlocksOf(turn);
    std::stable_sort(
        order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return work[a] > work[b]; });
    std::vector<int64_t> sums(groups_, 0);
    for (const uint32_t block : order) {
      const auto least = std::min_element(sums.begin(), sums.end());
      *least += work[block];
      of_block_[block] = size_t(least - sums.begin());
    }
  }
}

}  // namespace cosplat
