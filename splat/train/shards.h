// What ranks send each other of their shares (splat/train/row_share.h), and rows of per-Gaussian
// arrays as messages.
//
// A rank sums the gradients of its share, has the moments of no other and updates it; then it sends
// what has changed to all others (ZeRO's first two stages: Rajbhandari et al. 2020).
#pragma once

#include <cstdint>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/gaussians.h"
#include "splat/train/density.h"
#include "splat/train/optimizer.h"
#include "splat/train/rank_messages.h"
#include "splat/train/ranks.h"
#include "splat/train/row_share.h"

namespace cosplat {

// What is sent of many Gaussians goes in parts of so many, so that the memory that messages take
// does not grow with the scene: 17 MB at degree 3. Only moments that change hands go by whole
// attributes.
constexpr size_t kRowsPerExchange = size_t(1) << 16;
constexpr size_t kGroupsPerExchange = kRowsPerExchange / kGaussianGroup;

RowShare ShareOf(const Ranks& ranks);

// The attributes.
RowArrays RowsOf(Gaussians& gaussians);
// Words of a packed group: its index, then for each array the numbers of its Gaussians.
size_t WordsPerGroup(const RowArrays& arrays);

struct PackedGroups {
  View<uint32_t> groups;
  RowArrays arrays;  // row kGaussianGroup * k is the first of groups[k]
};
// Where packed groups are in `words`. arrays: their widths count.
PackedGroups FindPacked(const RowArrays& arrays, View<uint32_t> words);

// Packs groups of Gaussians: their indices, then array by array. The last group of all, of
// `gaussians`, is filled up with zeros. Everything is in the stream's memory.
void PackGroups(const RowArrays& arrays,
                View<const uint32_t> groups,
                size_t gaussians,
                Message& message,
                Stream& stream);
void UnpackGroups(const RowArrays& arrays,
                  size_t gaussians,
                  const PackedGroups& packed,
                  Stream& stream);

class Shards {
 public:
  explicit Shards(Ranks& ranks) : ranks_(ranks), share_(ShareOf(ranks)), messages_(ranks) {}
  const RowShare& share() const { return share_; }

  // All ranks make these calls together. What they are given is in the stream's memory.

  // After Adam's step or catch-up: sends the Gaussians of the groups that it updated (adam.behind)
  // to all ranks and takes over theirs. Returns the number of groups updated, over all ranks.
  size_t ShareUpdated(Gaussians& gaussians, AdamState& adam, Stream& stream);
  // Before anything that needs the statistics of all Gaussians: takes over the other ranks' shares
  // of them. ignored: gradients, of all ranks, as of the previous call, and updated.
  void Assemble(AdamState& adam, DensityStatistics& statistics, uint32_t& ignored, Stream& stream);
  // When density control reorders the Gaussians: hands their moments over to those who now own
  // them. Throws Error as CheckAlike does.
  void Gather(const Reordering& order, AdamState& adam, Stream& stream);

  // For checkpoints, in host memory. [begin, end): rows of an array of `width` numbers each that is
  // divided between the ranks, from the first of a block on. On rank 0 returns these rows,
  // elsewhere none.
  Buffer<float> Assembled(const Buffer<float>& own, size_t width, size_t begin, size_t end);
  // The other way round, on any rank by itself: copies its share of them to where it has it.
  void TakeOwn(
      const Buffer<float>& rows, size_t width, size_t begin, size_t end, Buffer<float>& own) const;

  // Numbers that this rank has sent of its moments.
  uint64_t moments_sent() const { return moments_sent_; }
  size_t HeldByMessages() const { return messages_.held() + HeldBy(groups_); }
  void Release() { messages_.Release(HostStream()); }

 private:
  Ranks& ranks_;
  RowShare share_;
  RankMessages messages_;
  Buffer<uint32_t> groups_;  // to be packed
  uint64_t moments_sent_ = 0;
};

}  // namespace cosplat
