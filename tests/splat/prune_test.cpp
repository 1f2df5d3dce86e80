// Which Gaussians go: small cases by hand, and the rules on random input.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "splat/base/rng.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

struct Input {
  std::vector<float> score;
  std::vector<uint8_t> exempt;
  std::vector<int32_t> group;

  std::vector<uint32_t> Select(size_t remove_lowest, int cap = 0, int floor = 0) {
    if (exempt.empty()) exempt.assign(score.size(), 0);
    return SelectForPruning({score, exempt, group, remove_lowest, cap, floor});
  }
};
using Indices = std::vector<uint32_t>;

TEST(Prune, TheLowestGo) {
  Input in{{3, 1, 4, 1.5f, 9, 2}, {}, {}};
  EXPECT_EQ(in.Select(0), Indices{});
  EXPECT_EQ(in.Select(1), Indices({1}));
  EXPECT_EQ(in.Select(3), Indices({1, 3, 5}));
  EXPECT_EQ(in.Select(100), Indices({0, 1, 2, 3, 4, 5}));
}

TEST(Prune, EqualScoresTheLowerIndex) {
  Input in{{2, 1, 1, 1, 2}, {}, {}};
  EXPECT_EQ(in.Select(2), Indices({1, 2}));
  EXPECT_EQ(in.Select(4), Indices({0, 1, 2, 3}));
}

TEST(Prune, TheExemptStay) {
  Input in{{0, 1, 0, 3}, {1, 0, 1, 0}, {}};
  EXPECT_EQ(in.Select(1), Indices({1}));
  EXPECT_EQ(in.Select(4), Indices({1, 3}));
}

TEST(Prune, TheSumOfTheScoresIsWithinTheLimit) {
  const std::vector<float> score{3, 1, 4, 1.5f, 9, 2};
  const auto select = [&](double limit, std::vector<uint8_t> exempt, size_t most = 6) {
    return SelectForPruning({score, exempt, {}, most, 0, 0, limit});
  };
  const std::vector<uint8_t> none(6, 0);
  EXPECT_EQ(select(0.9, none), Indices{});
  EXPECT_EQ(select(4.5, none), Indices({1, 3, 5}));
  EXPECT_EQ(select(4.5, none, 2), Indices({1, 3}));
  EXPECT_EQ(select(4.5, {0, 1, 0, 0, 0, 0}), Indices({3, 5}));  // who stays costs nothing
}

TEST(Prune, TheFloorHolds) {
  // Group 0 has the lowest scores but keeps two of its three; group 1 pays the rest.
  Input in{{1, 2, 3, 10, 11, 12}, {}, {0, 0, 0, 1, 1, 1}};
  EXPECT_EQ(in.Select(2, 0, 2), Indices({0, 3}));
  EXPECT_EQ(in.Select(6, 0, 2), Indices({0, 3}));
  EXPECT_EQ(in.Select(6, 0, 1), Indices({0, 1, 3, 4}));
}

TEST(Prune, TheCapTakesTheLowestOfItsGroupAndNewOnesLast) {
  Input in{{5, 1, 3, 0, 2, 7}, {0, 0, 0, 1, 0, 0}, {0, 0, 0, 0, 1, 1}};
  EXPECT_EQ(in.Select(0, 3), Indices({1}));
  EXPECT_EQ(in.Select(0, 2), Indices({1, 2}));
  EXPECT_EQ(in.Select(0, 1), Indices({0, 1, 2, 4}));  // the new one is left
  // All are new: the cap holds all the same.
  Input fresh{{0, 0, 0}, {1, 1, 1}, {0, 0, 0}};
  EXPECT_EQ(fresh.Select(0, 1), Indices({0, 1}));
}

TEST(Prune, CapAndLowestTogether) {
  // The cap takes 0; the two lowest of what is left are 1 and 4.
  Input in{{1, 2, 3, 9, 2.5f, 8}, {}, {0, 0, 0, 1, 1, 1}};
  EXPECT_EQ(in.Select(1, 2), Indices({0, 1, 4}));
  EXPECT_EQ(in.Select(2, 0), Indices({0, 1}));
}

TEST(Prune, Nothing) {
  Input in;
  EXPECT_EQ(in.Select(5, 2, 1), Indices{});
}

TEST(Prune, TheRulesHoldOnRandomInput) {
  Rng rng{1};
  for (int round = 0; round < 200; ++round) {
    const size_t n = 1 + rng.Below(60);
    const int groups = 1 + int(rng.Below(8)), cap = int(rng.Below(12)), floor = int(rng.Below(4));
    const size_t lowest = rng.Below(n + 5);
    Input in;
    for (size_t i = 0; i < n; ++i) {
      in.score.push_back(float(rng.Below(6)));  // many ties
      in.exempt.push_back(rng.Below(4) == 0);
      in.group.push_back(int(rng.Below(groups)));
    }
    const Indices removed = in.Select(lowest, cap, floor);
    ASSERT_TRUE(std::is_sorted(removed.begin(), removed.end()));
    ASSERT_TRUE(std::adjacent_find(removed.begin(), removed.end()) == removed.end());
    std::map<int, int> before, after;
    std::vector<bool> gone(n);
    for (const uint32_t i : removed) gone[i] = true;
    for (size_t i = 0; i < n; ++i) {
      ++before[in.group[i]];
      after[in.group[i]] += !gone[i];
    }
    size_t over_cap = 0;
    for (const auto& [group, count] : before) {
      if (cap > 0) {
        EXPECT_LE(after[group], cap);
        over_cap += std::max(0, count - cap);
      }
      const int lower = cap > 0 ? std::min(floor, cap) : floor;
      EXPECT_GE(after[group], std::min(count, lower)) << "group " << group;
    }
    EXPECT_LE(removed.size(), lowest + over_cap);
    // Of those that went for their score, none was better than one that could have gone.
    if (cap > 0) continue;
    float worst_removed = 0;
    for (const uint32_t i : removed) {
      EXPECT_FALSE(in.exempt[i]);
      worst_removed = std::max(worst_removed, in.score[i]);
    }
    for (size_t i = 0; i < n; ++i)
      if (!gone[i] && !in.exempt[i] && after[in.group[i]] > floor) {
        EXPECT_GE(in.score[i], worst_removed);
      }
  }
}

}  // namespace
}  // namespace cosplat
