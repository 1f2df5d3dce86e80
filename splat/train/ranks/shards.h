// Arrays of Gaussians that are divided between ranks (splat/train/ranks/row_share.h): assembled
// where all are needed, handed over where density control reorders them.
//
// Each rank has the Gaussians of its share, with their moments and statistics, and no others
// (ZeRO's third stage: Rajbhandari et al. 2020). What a step needs of the others':
// splat/train/ranks/view_exchange.h.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/gaussians.h"
#include "splat/train/ranks/rank_messages.h"
#include "splat/train/ranks/ranks.h"
#include "splat/train/ranks/row_share.h"
#include "splat/train/state/density_statistics.h"

namespace cosplat {

// What is sent of many Gaussians goes in parts of so many, so that the memory that messages take
// does not grow with the scene: 17 MB at degree 3. Only what changes hands goes by whole arrays.
constexpr size_t kRowsPerExchange = size_t(1) << 16;

RowShare ShareOf(const Ranks& ranks);
inline size_t GroupCount(size_t rows) { return (rows + kGaussianGroup - 1) / kGaussianGroup; }

// The attributes.
RowArrays RowsOf(Gaussians& gaussians);
// The same arrays from a row on.
RowArrays RowsFrom(const RowArrays& arrays, size_t row);
// Packed groups, array by array, in a message of whole groups. arrays: their widths count.
RowArrays PackedIn(const RowArrays& arrays, View<uint32_t> message);
// Makes groups the message. Everything is in the stream's memory.
void PackGroups(const GroupPlaces& from, size_t groups, Message& message, Stream& stream);
void UnpackGroups(const Message& message, size_t groups, const GroupPlaces& to, Stream& stream);

// Entries of an array that is divided between ranks, for rows [begin, end) of all, where a block
// begins: so many numbers for every so many rows.
struct Stretch {
  size_t begin = 0, end = 0;
  size_t width = 1;
  size_t rows_per_entry = 1;
};
enum class ForWhom { kFirstRank, kAllRanks };

// An own array whose rows density control reorders; those from first_zero on become zero.
struct HandedOver {
  Buffer<float>* values;
  size_t width;
  size_t first_zero;
};

class Shards {
 public:
  explicit Shards(Ranks& ranks) : ranks_(ranks), share_(ShareOf(ranks)), messages_(ranks) {}
  const RowShare& share() const { return share_; }
  // Whether there is more than this rank.
  bool divides() const { return share_.ranks > 1; }

  // All ranks make these calls together. What they are given is in the stream's memory.

  // own: [own rows] -> all: [count], on all ranks.
  void Assemble(const RowArrays& own, const RowArrays& all, size_t count, Stream& stream);
  // Gathers the arrays of Gaussians by `order`. Throws Error as CheckAlike does.
  void Gather(const Reordering& order, const std::vector<HandedOver>& arrays, Stream& stream);
  // In host memory: the rows of all, on one rank or all of them; elsewhere none.
  template <class T>
  Buffer<T> Assembled(const Buffer<T>& own, const Stretch& rows, ForWhom whom);

  // The other way round, on any rank by itself.
  void TakeOwn(const RowArrays& all, const RowArrays& own, size_t count, Stream& stream);
  template <class T>
  void TakeOwn(const Buffer<T>& all, const Stretch& rows, Buffer<T>& own) const;

  // In host memory: own Gaussians, of all that this rank has; and all, on the first rank, elsewhere
  // none. All ranks call the latter. count: of all.
  Gaussians OwnOf(const Gaussians& all);
  Gaussians AllOf(const Gaussians& own, size_t count);

  // Whether any rank's array has something, as this one's may not if there are few Gaussians. All
  // ranks call it.
  template <class T>
  bool AnyHas(const Buffer<T>& own) {
    return Largest(own.empty() ? 0 : 1, ranks_) != 0;
  }

  // Over all ranks, which all call it.
  uint64_t SumOver(uint64_t own) { return Sum(own, ranks_); }

  // Numbers that this rank has sent by Gather and Assembled.
  uint64_t numbers_sent() const { return numbers_sent_; }
  size_t MessageBytes() const {
    return messages_.allocated_bytes() + AllocatedBytes(message_, groups_);
  }
  void Release();

 private:
  // For the blocks of a rank in a stretch: copy(entry of the stretch, entry of the rank, entries).
  template <class Copy>
  static void ForEachBlock(const RowShare& share, const Stretch& rows, const Copy& copy);
  // The groups of `rows` of a rank's own rows from `place` on.
  View<const uint32_t> GroupsOf(const RowShare& share, size_t place, size_t rows, Stream& stream);

  Ranks& ranks_;
  RowShare share_;
  RankMessages messages_;
  Message message_;
  Buffer<uint32_t> groups_;
  uint64_t numbers_sent_ = 0;
};

template <class Copy>
void Shards::ForEachBlock(const RowShare& share, const Stretch& rows, const Copy& copy) {
  const size_t per = rows.rows_per_entry;
  for (size_t row = rows.begin; row < rows.end; row += kRowsPerBlock)
    if (share.Owns(row))
      copy((row - rows.begin) / per,
           share.PlaceOf(row) / per,
           (std::min(kRowsPerBlock, rows.end - row) + per - 1) / per);
}

template <class T>
Buffer<T> Shards::Assembled(const Buffer<T>& own, const Stretch& rows, ForWhom whom) {
  const size_t width = rows.width, per = rows.rows_per_entry;
  const auto entries = [&](size_t n) { return (n + per - 1) / per; };
  const auto first = [&](const RowShare& share) { return entries(share.CountOf(rows.begin)); };
  const size_t numbers = (entries(share_.CountOf(rows.end)) - first(share_)) * width;
  Message message((numbers * sizeof(T) + sizeof(uint32_t) - 1) / sizeof(uint32_t));
  if (numbers != 0)
    std::memcpy(message.data(), own.data() + first(share_) * width, numbers * sizeof(T));
  std::vector<View<const uint32_t>> to(share_.ranks);
  for (uint32_t r = 0; r < share_.ranks; ++r)
    if (r != share_.rank && (r == 0 || whom == ForWhom::kAllRanks)) {
      to[r] = message;
      numbers_sent_ += message.size();
    }
  std::vector<Message> from;
  ranks_.Exchange(to, from);
  from[share_.rank] = std::move(message);
  Buffer<T> all;
  if (share_.rank != 0 && whom == ForWhom::kFirstRank) return all;
  all.resize(entries(rows.end - rows.begin) * width);
  for (uint32_t r = 0; r < share_.ranks; ++r) {
    const RowShare share{r, share_.ranks};
    const T* const part = reinterpret_cast<const T*>(from[r].data());
    ForEachBlock(share, rows, [&](size_t to_entry, size_t entry, size_t n) {
      std::copy_n(part + (entry - first(share)) * width, n * width, all.data() + to_entry * width);
    });
  }
  return all;
}

template <class T>
void Shards::TakeOwn(const Buffer<T>& all, const Stretch& rows, Buffer<T>& own) const {
  const size_t width = rows.width;
  ForEachBlock(share_, rows, [&](size_t from_entry, size_t entry, size_t n) {
    std::copy_n(all.data() + from_entry * width, n * width, own.data() + entry * width);
  });
}

}  // namespace cosplat
