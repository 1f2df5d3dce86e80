// What ranks send each other of their shares (splat/train/row_share.h), and rows of per-Gaussian
// arrays as messages.
//
// A rank sums the gradients of its share, has the moments of no other and updates it; then it sends
// what has changed to all others (ZeRO's first two stages: Rajbhandari et al. 2020).
#pragma once

#include <cstdint>
#include <vector>

#include "splat/gaussians.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/density.h"
#include "splat/train/optimizer.h"
#include "splat/train/ranks.h"
#include "splat/train/row_share.h"

namespace cosplat {

constexpr size_t kGroupsPerBlock = kRowsPerBlock / kGaussianGroup;
// What is sent of many Gaussians goes in parts of so many, so that the memory that messages take
// does not grow with the scene. 17 MB at degree 3.
constexpr size_t kRowsPerExchange = size_t(1) << 16;
constexpr size_t kGroupsPerExchange = kRowsPerExchange / kGaussianGroup;

RowShare ShareOf(const Ranks& ranks);

// An array with `width` numbers per Gaussian.
struct RowArray {
  float* data = nullptr;
  size_t width = 0;
};
std::vector<RowArray> RowsOf(Gaussians& gaussians);

// Words of a message per group: its index, and whole groups of rows.
size_t WordsPerGroup(const std::vector<RowArray>& arrays);

// Makes a message of a header and these groups of `count` Gaussians. Layout: the header, the
// groups' indices, then array by array their rows, kGaussianGroup for every group.
void PackGroups(View<const uint32_t> header,
                const std::vector<RowArray>& arrays,
                View<const uint32_t> groups,
                size_t count,
                Message& message);
// Finds them in the words after the header.
struct PackedGroups {
  View<const uint32_t> groups;
  std::vector<RowArray> arrays;  // row kGaussianGroup * k is the first of groups[k]
};
PackedGroups FindPacked(const std::vector<RowArray>& arrays, View<uint32_t> words);
// Copies them to where they belong.
void UnpackGroups(const std::vector<RowArray>& arrays, size_t count, View<uint32_t> words);

class Shards {
 public:
  explicit Shards(Ranks& ranks) : ranks_(ranks), share_(ShareOf(ranks)) {}
  const RowShare& share() const { return share_; }

  // All ranks make these calls together.

  // After Adam's step or catch-up: sends the Gaussians of the groups that it updated (adam.behind)
  // to all ranks and takes over theirs. Returns the number of groups updated, over all ranks.
  size_t ShareUpdated(Gaussians& gaussians, AdamState& adam);
  // Before anything that needs the statistics of all Gaussians: takes over the other ranks' shares
  // of them. ignored: gradients, of all ranks, as of the previous call, and updated.
  void Assemble(AdamState& adam, DensityStatistics& statistics, uint32_t& ignored);
  // When density control reorders the Gaussians: hands their moments over to those who now own
  // them.
  void Gather(const Reordering& order, AdamState& adam);
  // For checkpoints. [begin, end): rows of an array of `width` numbers each that is divided between
  // the ranks, from the first of a block on. On rank 0 returns these rows, elsewhere none.
  Buffer<float> Assembled(const Buffer<float>& own, size_t width, size_t begin, size_t end);
  // The other way round, on any rank by itself: copies its share of them to where it has it.
  void TakeOwn(
      const Buffer<float>& rows, size_t width, size_t begin, size_t end, Buffer<float>& own) const;

  // Numbers that this rank has sent of its moments.
  uint64_t moments_sent() const { return moments_sent_; }

 private:
  Ranks& ranks_;
  RowShare share_;
  uint64_t moments_sent_ = 0;
};

}  // namespace cosplat
