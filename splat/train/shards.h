// Which rank updates which Gaussians, and rows of per-Gaussian arrays as messages.
//
// The ranks' shares are blocks of neighbouring groups (kGaussianGroup) in turn: a view sees one
// region, and neighbours in the arrays are neighbours in space, so that every rank has its part of
// what a view moves. A rank sums the gradients of its share, keeps its moments and updates it; then
// it sends what has changed to all others (ZeRO's first stage: Rajbhandari et al. 2020).
#pragma once

#include <cstdint>
#include <vector>

#include "splat/gaussians.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/density.h"
#include "splat/train/optimizer.h"
#include "splat/train/ranks.h"

namespace cosplat {

// As many Gaussians as Adam updates in one run of its inner loop.
constexpr size_t kGroupsPerBlock = 32;

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
  explicit Shards(Ranks& ranks) : ranks_(ranks) {}
  size_t OwnerOf(size_t group) const { return group / kGroupsPerBlock % ranks_.size(); }
  bool Owns(size_t group) const { return OwnerOf(group) == ranks_.rank(); }

  // After Adam's step: sends the Gaussians of the own groups that it updated (adam.updated) to all
  // ranks and takes over theirs. Returns the number of groups updated, over all ranks.
  size_t ShareUpdated(Gaussians& gaussians, const AdamState& adam);
  // Before anything that needs the moments and statistics of all Gaussians: takes over the other
  // ranks' shares. ignored: as of the previous call, and updated.
  void Assemble(AdamState& adam, DensityStatistics& statistics, uint32_t& ignored);

 private:
  Ranks& ranks_;
};

}  // namespace cosplat
