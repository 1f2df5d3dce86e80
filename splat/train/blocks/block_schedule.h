// When the blocks of a scene (splat/train/blocks/blocks.h) are trained, and by which ranks.
//
// The whole scene is trained first, in round 0. In each later round every block is trained, seeing
// what the others had become by the end of the round before; so all blocks of a round can be
// trained at the same time, by whomever.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cosplat {

constexpr uint32_t kBlockRounds = 2;  // after the whole scene's (measured: docs/tried.md)

// The iteration, of a training of `iterations`, with which a round ends: a multiple of the batch
// or, of the last one, `iterations`.
int EndOfBlockRound(uint32_t round, int iterations, int batch);

// Ranks that train a block together: as many groups as there are blocks, if there are as many
// ranks. Neighbours, which mpirun starts on one machine, are in one group.
class BlockGroups {
 public:
  BlockGroups() = default;
  // work: of each block, in any unit. The block with the most work first goes to the group that has
  // the least.
  BlockGroups(const std::vector<int>& work, size_t ranks);

  size_t count() const { return groups_; }
  size_t GroupOf(size_t rank) const { return rank * groups_ / ranks_; }
  size_t OfBlock(size_t block) const { return of_block_[block]; }

 private:
  size_t ranks_ = 1, groups_ = 1;
  std::vector<size_t> of_block_;
};

}  // namespace cosplat
