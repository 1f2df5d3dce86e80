#include "splat/train/shards.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "splat/train/kernels/adam.h"

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

// Calls copy(row, place, rows) for the blocks of a share in [begin, end), where a block begins.
template <class Copy>
void ForEachBlock(const RowShare& share, size_t begin, size_t end, const Copy& copy) {
  for (size_t row = begin; row < end; row += kRowsPerBlock)
    if (share.Owns(row)) copy(row, share.PlaceOf(row), std::min(kRowsPerBlock, end - row));
}

// Rows of own moments, by the rank that they go to or come from.
struct Transfers {
  std::vector<std::vector<uint32_t>> sent, received;  // places in the old and in the new share
};

Transfers TransfersOf(const Reordering& order, const RowShare& share) {
  Transfers all;
  all.sent.resize(share.ranks);
  all.received.resize(share.ranks);
  for (size_t row = 0; row < order.first_fresh; ++row) {
    const size_t source = order.source[row];
    const size_t from = share.OwnerOf(source), to = share.OwnerOf(row);
    if (from == share.rank) all.sent[to].push_back(uint32_t(share.PlaceOf(source)));
    if (to == share.rank) all.received[from].push_back(uint32_t(share.PlaceOf(row)));
  }
  return all;
}

// Rows of `width` numbers one after another.
void PackRows(const Buffer<float>& from,
              size_t width,
              const std::vector<uint32_t>& rows,
              Message& message) {
  message.Refill(rows.size() * width);
  float* to = reinterpret_cast<float*>(message.data());
  for (size_t k = 0; k < rows.size(); ++k)
    std::copy_n(from.data() + rows[k] * width, width, to + k * width);
}

void UnpackRows(const Message& message,
                size_t width,
                const std::vector<uint32_t>& rows,
                Buffer<float>& to) {
  const float* from = reinterpret_cast<const float*>(message.data());
  for (size_t k = 0; k < rows.size(); ++k)
    std::copy_n(from + k * width, width, to.data() + rows[k] * width);
}

}  // namespace

RowShare ShareOf(const Ranks& ranks) { return {uint32_t(ranks.rank()), uint32_t(ranks.size())}; }

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

size_t Shards::ShareUpdated(Gaussians& gaussians, AdamState& adam) {
  const std::vector<RowArray> rows = RowsOf(gaussians);
  std::vector<uint32_t> updated;
  Message message;
  std::vector<Message> from;
  size_t groups = 0;
  for (size_t begin = 0; begin < adam.behind.size(); begin += kGroupsPerExchange) {
    const size_t end = std::min(begin + kGroupsPerExchange, adam.behind.size());
    updated.clear();
    for (size_t g = begin; g < end; ++g)
      if (adam.behind[g] != kNotNow) updated.push_back(uint32_t(g));
    groups += updated.size();
    if (share_.ranks == 1) continue;
    PackGroups({}, rows, updated, gaussians.size(), message);
    ranks_.Exchange(std::vector<View<const uint32_t>>(share_.ranks, message), from);
    for (Message& other : from) {
      UnpackGroups(rows, gaussians.size(), other.view());
      for (const uint32_t g : FindPacked(rows, other.view()).groups) adam.updated[g] = adam.step;
      groups += other.size() / WordsPerGroup(rows);
    }
  }
  return groups;
}

void Shards::Assemble(AdamState& adam, DensityStatistics& statistics, uint32_t& ignored) {
  if (ranks_.size() == 1) return;
  const size_t count = statistics.visible.size();
  std::vector<RowArray> rows;
  for (Buffer<float>* of_all : statistics.all()) rows.push_back({of_all->data(), 1});
  std::vector<uint32_t> own;
  for (size_t g = 0; g < AdamGroupCount(count); ++g)
    if (share_.Owns(g * kGaussianGroup)) own.push_back(uint32_t(g));
  const uint32_t newly_ignored = adam.ignored[0] - ignored;
  Message message;
  PackGroups({&newly_ignored, 1}, rows, own, count, message);
  for (Message& other : ExchangeWithAll(message, ranks_)) {
    if (other.empty()) continue;
    UnpackGroups(rows, count, {other.data() + 1, other.size() - 1});
    adam.ignored[0] += other[0];
  }
  ignored = adam.ignored[0];
}

void Shards::Gather(const Reordering& order, AdamState& adam) {
  const Transfers rows = TransfersOf(order, share_);
  const size_t own = share_.CountOf(order.source.size());
  std::vector<Message> to(share_.ranks), from;
  Message kept;
  for (Gaussians* moments : {&adam.m, &adam.v})
    for (int a = 0; a < kAttributeCount; ++a) {
      const size_t width = size_t(moments->width(a));
      for (size_t r = 0; r < share_.ranks; ++r) {
        const bool here = r == share_.rank;
        PackRows(moments->values[a], width, rows.sent[r], here ? kept : to[r]);
        if (!here) moments_sent_ += to[r].size();
      }
      ranks_.Exchange({to.begin(), to.end()}, from);
      moments->values[a] = Buffer<float>(own * width, 0.0f);
      for (size_t r = 0; r < share_.ranks; ++r)
        UnpackRows(r == share_.rank ? kept : from[r], width, rows.received[r], moments->values[a]);
    }
}

Buffer<float> Shards::Assembled(const Buffer<float>& own, size_t width, size_t begin, size_t end) {
  std::vector<View<const uint32_t>> to(share_.ranks);
  std::vector<Message> from;
  const auto part_of = [&](const RowShare& share) { return share.CountOf(begin) * width; };
  if (share_.rank != 0) {
    to[0] = {reinterpret_cast<const uint32_t*>(own.data() + part_of(share_)),
             share_.CountOf(end) * width - part_of(share_)};
    moments_sent_ += to[0].size();
  }
  ranks_.Exchange(to, from);
  Buffer<float> all;
  if (share_.rank != 0) return all;
  all.resize((end - begin) * width);
  for (uint32_t r = 0; r < share_.ranks; ++r) {
    const RowShare share{r, share_.ranks};
    const float* part =
        r == 0 ? own.data() + part_of(share) : reinterpret_cast<const float*>(from[r].data());
    ForEachBlock(share, begin, end, [&](size_t row, size_t place, size_t n) {
      std::copy_n(
          part + (place * width - part_of(share)), n * width, all.data() + (row - begin) * width);
    });
  }
  return all;
}

void Shards::TakeOwn(
    const Buffer<float>& rows, size_t width, size_t begin, size_t end, Buffer<float>& own) const {
  ForEachBlock(share_, begin, end, [&](size_t row, size_t place, size_t n) {
    std::copy_n(rows.data() + (row - begin) * width, n * width, own.data() + place * width);
  });
}

}  // namespace cosplat
