#include "splat/train/ranks/shards.h"

#include <algorithm>

#include "splat/device/for_each.h"
#include "splat/device/gather.h"
#include "splat/train/ranks/kernels/shards.h"

namespace cosplat {
namespace {

// Rows of own arrays, by the rank that they go to or come from.
struct Transfers {
  std::vector<std::vector<uint32_t>> sent, received;  // places in the old and in the new share
};

Transfers TransfersOf(View<const uint32_t> source, size_t first_zero, const RowShare& share) {
  Transfers all;
  all.sent.resize(share.ranks);
  all.received.resize(share.ranks);
  for (size_t row = 0; row < first_zero; ++row) {
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
  for (size_t r = 0; r < lists.size(); ++r) copies[r].Upload(lists[r], stream);
  return copies;
}

std::vector<uint32_t> Downloaded(View<const uint32_t> numbers, Stream& stream) {
  std::vector<uint32_t> copy(numbers.count);
  if (!copy.empty()) stream.Download(copy.data(), numbers.data, copy.size() * sizeof(uint32_t));
  stream.Wait();
  return copy;
}

const float* Floats(const Message& message) {
  return reinterpret_cast<const float*>(message.data());
}

}  // namespace

RowShare ShareOf(const Ranks& ranks) { return {uint32_t(ranks.rank()), uint32_t(ranks.size())}; }

RowArrays RowsOf(Gaussians& gaussians) {
  RowArrays arrays;
  for (int a = 0; a < kAttributeCount; ++a)
    arrays.Add({gaussians.values[a].data(), size_t(gaussians.width(a))});
  return arrays;
}

RowArrays RowsFrom(const RowArrays& arrays, size_t row) {
  RowArrays rest;
  for (size_t a = 0; a < arrays.count; ++a)
    rest.Add({arrays.array[a].data + row * arrays.array[a].width, arrays.array[a].width});
  return rest;
}

RowArrays PackedIn(const RowArrays& arrays, View<uint32_t> message) {
  const size_t groups = arrays.numbers() == 0 ? 0 : message.size() / arrays.numbers();
  RowArrays packed;
  float* next = reinterpret_cast<float*>(message.data);
  for (size_t a = 0; a < arrays.count; ++a) {
    packed.Add({next, arrays.array[a].width});
    next += groups * kGaussianGroup * arrays.array[a].width;
  }
  return packed;
}

void PackGroups(const GroupPlaces& from, size_t groups, Message& message, Stream& stream) {
  message.Refill(groups * from.arrays.numbers(), stream);
  const RowArrays packed = PackedIn(from.arrays, message.view());
  ForEachGroup(groups, stream, CopyGroup{from, {packed, groups * kGaussianGroup}});
}

void UnpackGroups(const Message& message, size_t groups, const GroupPlaces& to, Stream& stream) {
  // Only read.
  const View<uint32_t> words(const_cast<uint32_t*>(message.data()), message.size());
  ForEachGroup(
      groups, stream, CopyGroup{{PackedIn(to.arrays, words), groups * kGaussianGroup}, to});
}

View<const uint32_t> Shards::GroupsOf(const RowShare& share,
                                      size_t place,
                                      size_t rows,
                                      Stream& stream) {
  std::vector<uint32_t> groups;
  for (size_t p = place; p < place + rows; p += kGaussianGroup)
    groups.push_back(uint32_t(share.RowAt(p) / kGaussianGroup));
  groups_.Upload(groups, stream);
  stream.Wait();
  return std::as_const(groups_).view();
}

void Shards::Assemble(const RowArrays& own, const RowArrays& all, size_t count, Stream& stream) {
  // Blocks of all ranks together.
  const size_t blocks = kRowsPerExchange / kRowsPerBlock / share_.ranks;
  const size_t part = std::max(blocks, size_t(1)) * kRowsPerBlock;
  const auto rows_from = [&](const RowShare& share, size_t place) {
    const size_t rows = share.CountOf(count);
    return rows > place ? std::min(rows - place, part) : 0;
  };
  // Rank 0 has the most.
  const size_t max = RowShare{0, share_.ranks}.CountOf(count);
  for (size_t place = 0; place < max; place += part) {
    const size_t rows = rows_from(share_, place);
    PackGroups({RowsFrom(own, place), rows}, GroupCount(rows), message_, stream);
    messages_.ExchangeWithAll(message_, stream);
    for (uint32_t r = 0; r < share_.ranks; ++r) {
      const RowShare share{r, share_.ranks};
      const size_t theirs = rows_from(share, place);
      UnpackGroups(r == share_.rank ? message_ : messages_.From(r),
                   GroupCount(theirs),
                   {all, count, GroupsOf(share, place, theirs, stream)},
                   stream);
    }
  }
}

void Shards::TakeOwn(const RowArrays& all, const RowArrays& own, size_t count, Stream& stream) {
  const size_t rows = share_.CountOf(count);
  ForEachGroup(GroupCount(rows),
               stream,
               CopyGroup{{all, count, GroupsOf(share_, 0, rows, stream)}, {own, rows}});
}

void Shards::Gather(const Reordering& order,
                    const std::vector<HandedOver>& arrays,
                    Stream& stream) {
  CheckAlike(order.source.size(), ranks_);
  const std::vector<uint32_t> source = Downloaded(order.source, stream);
  const size_t own = share_.CountOf(source.size());
  std::vector<Message> to(share_.ranks);
  size_t first_zero = 0;
  std::vector<Buffer<uint32_t>> sent, received;
  for (const HandedOver& array : arrays) {
    CheckAlike(array.first_zero, ranks_);
    if (sent.empty() || array.first_zero != first_zero) {
      first_zero = array.first_zero;
      const Transfers rows = TransfersOf(source, first_zero, share_);
      sent = Uploaded(rows.sent, stream);
      received = Uploaded(rows.received, stream);
      stream.Wait();
    }
    Buffer<float>& values = *array.values;
    const size_t width = array.width;
    for (size_t r = 0; r < share_.ranks; ++r) {
      to[r].Refill(sent[r].size() * width, stream);
      const View<float> floats(reinterpret_cast<float*>(to[r].data()), to[r].size());
      ForEach(
          sent[r].size(),
          stream,
          GatherRow<float>{std::as_const(values).view(), sent[r], width, sent[r].size(), floats});
      if (r != share_.rank) numbers_sent_ += to[r].size();
    }
    messages_.Exchange(to, stream);
    values.Refill(own * width, stream);
    values.FillWithZeros(stream);
    for (size_t r = 0; r < share_.ranks; ++r)
      ForEach(received[r].size(),
              stream,
              ScatterRow{Floats(r == share_.rank ? to[r] : messages_.From(r)),
                         received[r],
                         width,
                         values.view()});
  }
  messages_.Release(stream);  // which grow with the scene
}

Gaussians Shards::OwnOf(const Gaussians& all) {
  if (!divides()) return all;
  Gaussians own = all.ZerosLike(share_.CountOf(all.size()));
  const Stretch rows{0, all.size()};
  TakeOwn(RowsOf(const_cast<Gaussians&>(all)), RowsOf(own), all.size(), HostStream());  // only read
  own.antialiased = all.antialiased;
  own.degrees.resize(all.degrees.empty() ? 0 : own.size());
  if (!all.degrees.empty()) TakeOwn(all.degrees, rows, own.degrees);
  own.smoothing.resize(all.smoothing.empty() ? 0 : own.size());
  if (!all.smoothing.empty()) TakeOwn(all.smoothing, rows, own.smoothing);
  return own;
}

Gaussians Shards::AllOf(const Gaussians& own, size_t count) {
  if (!divides()) return own;
  Gaussians all = own.ZerosLike(0);
  all.antialiased = own.antialiased;
  const auto assemble = [&](const auto& from, size_t width, auto& to) {
    if (share_.rank == 0) to.reserve(count * width);
    for (size_t begin = 0; begin < count; begin += kRowsPerExchange) {
      const Stretch rows{begin, std::min(begin + kRowsPerExchange, count), width};
      const auto part = Assembled(from, rows, ForWhom::kFirstRank);
      to.append(part.begin(), part.end());
    }
  };
  for (int a = 0; a < kAttributeCount; ++a)
    assemble(own.values[a], size_t(own.width(a)), all.values[a]);
  if (AnyHas(own.degrees)) assemble(own.degrees, 1, all.degrees);
  if (AnyHas(own.smoothing)) assemble(own.smoothing, 1, all.smoothing);
  return all;
}

void Shards::Release() {
  messages_.Release(HostStream());
  message_ = {};
  groups_ = {};
}

}  // namespace cosplat
