#include "splat/train/shards.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace cosplat {
namespace {

// Calls copy(k, rows, row): `rows` Gaussians from `row` on belong to groups[k].
template <class Copy>
void ForEachGroup(View<const uint32_t> groups, size_t count, const Copy& copy) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, groups.size(), kGroupsPerBlock),
                    [&](const auto& range) {
                      for (size_t k = range.begin(); k < range.end(); ++k) {
                        const size_t row = kGaussianGroup * groups[k];
                        copy(k, std::min(kGaussianGroup, count - row), row);
                      }
                    });
}

std::vector<RowArray> Joined(std::vector<RowArray> a, const std::vector<RowArray>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

std::vector<RowArray> RowsOf(Gaussians& gaussians) {
  std::vector<RowArray> arrays;
  for (int a = 0; a < kAttributeCount; ++a)
    arrays.push_back({gaussians.values[a].data(), size_t(gaussians.width(a))});
  return arrays;
}

size_t WordsPerGroup(const std::vector<RowArray>& arrays) {
  size_t words = 1;
  for (const RowArray& array : arrays) words += kGaussianGroup * array.width;
  return words;
}

PackedGroups FindPacked(const std::vector<RowArray>& arrays, View<uint32_t> words) {
  const size_t groups = words.size() / WordsPerGroup(arrays);
  PackedGroups packed{{words.data, groups}, {}};
  float* next = reinterpret_cast<float*>(words.data + groups);
  for (const RowArray& array : arrays) {
    packed.arrays.push_back({next, array.width});
    next += groups * kGaussianGroup * array.width;
  }
  return packed;
}

void PackGroups(View<const uint32_t> header,
                const std::vector<RowArray>& arrays,
                View<const uint32_t> groups,
                size_t count,
                Message& message) {
  const size_t before = header.size();
  message.Refill(before + groups.size() * WordsPerGroup(arrays));
  std::copy(header.begin(), header.end(), message.data());
  std::copy(groups.begin(), groups.end(), message.data() + before);
  const PackedGroups packed =
      FindPacked(arrays, {message.data() + before, message.size() - before});
  ForEachGroup(groups, count, [&](size_t k, size_t rows, size_t row) {
    for (size_t a = 0; a < arrays.size(); ++a) {
      const size_t width = arrays[a].width;
      float* to = packed.arrays[a].data + k * kGaussianGroup * width;
      std::copy_n(arrays[a].data + row * width, rows * width, to);
      std::fill(to + rows * width, to + kGaussianGroup * width, 0.0f);
    }
  });
}

void UnpackGroups(const std::vector<RowArray>& arrays, size_t count, View<uint32_t> words) {
  const PackedGroups packed = FindPacked(arrays, words);
  ForEachGroup(packed.groups, count, [&](size_t k, size_t rows, size_t row) {
    for (size_t a = 0; a < arrays.size(); ++a) {
      const size_t width = arrays[a].width;
      std::copy_n(packed.arrays[a].data + k * kGaussianGroup * width,
                  rows * width,
                  arrays[a].data + row * width);
    }
  });
}

size_t Shards::ShareUpdated(Gaussians& gaussians, const AdamState& adam) {
  std::vector<uint32_t> updated;
  for (size_t g = 0; g < adam.updated.size(); ++g)
    if (adam.updated[g] == adam.step && Owns(g)) updated.push_back(uint32_t(g));
  size_t groups = updated.size();
  if (ranks_.size() == 1) return groups;
  const std::vector<RowArray> rows = RowsOf(gaussians);
  Message message;
  PackGroups({}, rows, updated, gaussians.size(), message);
  for (Message& other : ExchangeWithAll(message, ranks_)) {
    UnpackGroups(rows, gaussians.size(), other.view());
    groups += other.size() / WordsPerGroup(rows);
  }
  return groups;
}

void Shards::Assemble(AdamState& adam, DensityStatistics& statistics, uint32_t& ignored) {
  if (ranks_.size() == 1) return;
  const size_t count = adam.m.size(), groups = adam.updated.size();
  std::vector<RowArray> rows = Joined(RowsOf(adam.m), RowsOf(adam.v));
  for (Buffer<float>* of_all : statistics.all()) rows.push_back({of_all->data(), 1});
  std::vector<uint32_t> own;
  for (size_t g = 0; g < groups; ++g)
    if (Owns(g)) own.push_back(uint32_t(g));
  // First the number of ignored gradients and the steps of the groups.
  std::vector<uint32_t> header{adam.ignored[0] - ignored};
  for (const uint32_t g : own) header.push_back(adam.updated[g]);
  Message message;
  PackGroups(header, rows, own, count, message);
  for (Message& other : ExchangeWithAll(message, ranks_)) {
    if (other.empty()) continue;
    const size_t theirs = (other.size() - 1) / (1 + WordsPerGroup(rows));
    const View<uint32_t> packed{other.data() + 1 + theirs, other.size() - 1 - theirs};
    UnpackGroups(rows, count, packed);
    for (size_t k = 0; k < theirs; ++k) adam.updated[packed[k]] = other[1 + k];
    adam.ignored[0] += other[0];
  }
  ignored = adam.ignored[0];
}

}  // namespace cosplat
