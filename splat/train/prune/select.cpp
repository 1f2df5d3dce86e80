#include <algorithm>
#include <numeric>

#include "splat/train/prune/rules.h"

namespace cosplat {

std::vector<uint32_t> SelectForPruning(const PruneRequest& request) {
  const size_t n = request.score.size();
  const auto group_of = [&](size_t i) { return request.group.empty() ? 0 : request.group[i]; };
  int groups = 1;
  for (const int32_t g : request.group) groups = std::max(groups, g + 1);
  std::vector<uint32_t> left(groups, 0);
  for (size_t i = 0; i < n; ++i) ++left[group_of(i)];

  std::vector<uint32_t> by_score(n);
  std::iota(by_score.begin(), by_score.end(), 0u);
  std::stable_sort(by_score.begin(), by_score.end(), [&](uint32_t a, uint32_t b) {
    return request.score[a] < request.score[b];
  });

  std::vector<uint32_t> removed;
  std::vector<uint8_t> gone(n, 0);
  const auto remove = [&](uint32_t i) {
    gone[i] = 1;
    --left[group_of(i)];
    removed.push_back(i);
  };
  // The cap first: new Gaussians have no score yet and are removed after those that have one.
  if (request.group_cap > 0)
    for (const bool take_exempt : {false, true})
      for (const uint32_t i : by_score)
        if (!gone[i] && bool(request.exempt[i]) == take_exempt &&
            left[group_of(i)] > uint32_t(request.group_cap))
          remove(i);
  size_t budget = request.remove_lowest;
  double sum = 0;
  for (const uint32_t i : by_score) {
    if (budget == 0) break;
    if (gone[i] || request.exempt[i] || left[group_of(i)] <= uint32_t(request.group_floor))
      continue;
    sum += request.score[i];
    if (sum > request.score_limit) break;
    remove(i);
    --budget;
  }
  std::sort(removed.begin(), removed.end());
  return removed;
}

}  // namespace cosplat
