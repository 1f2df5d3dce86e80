#include "splat/train/shards.h"

#include <algorithm>

#include "splat/device/for_each.h"
#include "splat/device/gather.h"
#include "splat/train/kernels/shards.h"

namespace cosplat {
namespace {

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

Transfers TransfersOf(View<const uint32_t> source, size_t first_fresh, const RowShare& share) {
  Transfers all;
  all.sent.resize(share.ranks);
  all.received.resize(share.ranks);
  for (size_t row = 0; row < first_fresh; ++row) {
    const size_t from = share.OwnerOf(source[row]), to = share.OwnerOf(row);
    if (from == share.rank) all.sent[to].push_back(uint32_t(share.PlaceOf(source[row])));
    if (to == share.rank) all.received[from].push_back(uint32_t(share.PlaceOf(row)));
  }
  return all;
}

// In a stream's memory.
std::vector<Buffer<uint32_t>> Uploaded(const std::vector<std::vector<uint32_t>>& lists,
                                       Stream& stream) {
  std::vector<Buffer<uint32_t>> copies(lists.size());
  for (size_t r = 0; r < lists.size(); ++r)
    copies[r].Upload(lists[r].data(), lists[r].size(), stream);
  return copies;
}

std::vector<uint32_t> Downloaded(View<const uint32_t> numbers, Stream& stream) {
  std::vector<uint32_t> copy(numbers.count);
  if (!copy.empty()) stream.Download(copy.data(), numbers.data, copy.size() * sizeof(uint32_t));
  stream.Wait();
  return copy;
}

View<float> Floats(Message& message) {
  return {reinterpret_cast<float*>(message.data()), message.size()};
}

}  // namespace

RowShare ShareOf(const Ranks& ranks) { return {uint32_t(ranks.rank()), uint32_t(ranks.size())}; }

RowArrays RowsOf(Gaussians& gaussians) {
  RowArrays arrays;
  for (int a = 0; a < kAttributeCount; ++a)
    arrays.Add({gaussians.values[a].data(), size_t(gaussians.width(a))});
  return arrays;
}

size_t WordsPerGroup(const RowArrays& arrays) { return 1 + arrays.numbers(); }

PackedGroups FindPacked(const RowArrays& arrays, View<uint32_t> words) {
  const size_t groups = words.size() / WordsPerGroup(arrays);
  PackedGroups packed{{words.data, groups}, {}};
  float* next = reinterpret_cast<float*>(words.data + groups);
  for (size_t a = 0; a < arrays.count; ++a) {
    packed.arrays.Add({next, arrays.array[a].width});
    next += groups * kGaussianGroup * arrays.array[a].width;
  }
  return packed;
}

void PackGroups(const RowArrays& arrays,
                View<const uint32_t> groups,
                size_t gaussians,
                Message& message,
                Stream& stream) {
  message.Refill(groups.size() * WordsPerGroup(arrays), stream);
  const PackedGroups packed = FindPacked(arrays, message.view());
  ForEachGroup(groups.size(),
               stream,
               PackGroup{arrays, packed.arrays, groups, packed.groups.data, gaussians});
}

void UnpackGroups(const RowArrays& arrays,
                  size_t gaussians,
                  const PackedGroups& packed,
                  Stream& stream) {
  ForEachGroup(
      packed.groups.size(), stream, UnpackGroup{packed.arrays, arrays, packed.groups, gaussians});
}

size_t Shards::ShareUpdated(Gaussians& gaussians, AdamState& adam, Stream& stream) {
  const RowArrays rows = RowsOf(gaussians);
  const std::vector<uint32_t> behind = Downloaded(adam.behind, stream);
  std::vector<uint32_t> updated;
  size_t groups = 0;
  for (size_t begin = 0; begin < behind.size(); begin += kGroupsPerExchange) {
    const size_t end = std::min(begin + kGroupsPerExchange, behind.size());
    updated.clear();
    for (size_t g = begin; g < end; ++g)
      if (behind[g] != kNotNow) updated.push_back(uint32_t(g));
    groups += updated.size();
    if (share_.ranks == 1) continue;
    groups_.Upload(updated.data(), updated.size(), stream);
    PackGroups(rows, groups_, gaussians.size(), messages_.To(share_.rank), stream);
    messages_.ExchangeWithAll(stream);
    for (size_t r = 0; r < share_.ranks; ++r) {
      if (r == share_.rank) continue;
      const PackedGroups packed = FindPacked(rows, messages_.From(r).view());
      UnpackGroups(rows, gaussians.size(), packed, stream);
      ForEach(
          packed.groups.size(), stream, SetOfGroups{packed.groups, adam.step, adam.updated.view()});
      groups += packed.groups.size();
    }
  }
  return groups;
}

void Shards::Assemble(AdamState& adam,
                      DensityStatistics& statistics,
                      uint32_t& ignored,
                      Stream& stream) {
  if (share_.ranks == 1) return;
  const size_t count = statistics.visible.size(), groups = AdamGroupCount(count);
  RowArrays rows;
  for (Buffer<float>* of_all : statistics.all()) rows.Add({of_all->data(), 1});
  for (size_t begin = 0; begin < groups; begin += kGroupsPerExchange) {
    std::vector<uint32_t> own;
    for (size_t g = begin; g < std::min(begin + kGroupsPerExchange, groups); ++g)
      if (share_.Owns(g * kGaussianGroup)) own.push_back(uint32_t(g));
    groups_.Upload(own.data(), own.size(), stream);
    PackGroups(rows, groups_, count, messages_.To(share_.rank), stream);
    messages_.ExchangeWithAll(stream);
    for (size_t r = 0; r < share_.ranks; ++r)
      if (r != share_.rank)
        UnpackGroups(rows, count, FindPacked(rows, messages_.From(r).view()), stream);
  }
  const uint32_t now = Downloaded(adam.ignored, stream)[0];
  ignored += uint32_t(Sum(now - ignored, ranks_));
  stream.Send(adam.ignored.data(), &ignored, sizeof ignored);
}

void Shards::Gather(const Reordering& order, AdamState& adam, Stream& stream) {
  CheckAlike(order.source.size(), ranks_);
  CheckAlike(order.first_fresh, ranks_);
  const std::vector<uint32_t> source = Downloaded(order.source, stream);
  const Transfers rows = TransfersOf(source, order.first_fresh, share_);
  const std::vector<Buffer<uint32_t>> sent = Uploaded(rows.sent, stream);
  const std::vector<Buffer<uint32_t>> received = Uploaded(rows.received, stream);
  const size_t own = share_.CountOf(source.size());
  Message kept;
  for (Gaussians* moments : {&adam.m, &adam.v})
    for (int a = 0; a < kAttributeCount; ++a) {
      Buffer<float>& values = moments->values[a];
      const size_t width = size_t(moments->width(a));
      for (size_t r = 0; r < share_.ranks; ++r) {
        Message& message = r == share_.rank ? kept : messages_.To(r);
        message.Refill(sent[r].size() * width, stream);
        ForEach(sent[r].size(),
                stream,
                GatherRow<float>{values.view(), sent[r], width, sent[r].size(), Floats(message)});
        if (r != share_.rank) moments_sent_ += message.size();
      }
      messages_.Exchange(stream);
      values.Refill(own * width, stream);
      values.FillWithZeros(stream);
      for (size_t r = 0; r < share_.ranks; ++r)
        ForEach(received[r].size(),
                stream,
                ScatterRow{Floats(r == share_.rank ? kept : messages_.From(r)).data,
                           received[r],
                           width,
                           values.view()});
    }
  messages_.Release(stream);  // which grow with the scene
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
