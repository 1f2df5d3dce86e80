// When the blocks of a scene (splat/train/blocks.h) are trained, and by which ranks.
//
// The whole scene is trained first, in turn 0. Then there are rounds, in each of which every block
// has its turn. It sees what the others had become by the end of the turn before. Blocks that share
// views have different turns, since both would make up for the same error (measured:
// docs/decisions.md); those of one turn can be trained at the same time, by whomever.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cosplat {

class BlockSchedule {
 public:
  BlockSchedule() = default;
  // views: that each block is trained on, ascending. Two blocks that have more than a tenth of the
  // views of the one with fewer in common have different turns.
  explicit BlockSchedule(const std::vector<std::vector<uint32_t>>& views);

  uint32_t turns_of_round() const { return uint32_t(blocks_.size()); }
  // Two or, where some blocks are trained at once, four (measured: docs/decisions.md).
  uint32_t rounds() const { return rounds_; }
  uint32_t last_turn() const { return rounds_ * turns_of_round(); }
  // The round of a turn, from 1; 0: the whole scene's turn.
  uint32_t RoundOf(uint32_t turn) const;
  // From turn 1 on: the blocks that are trained in it, ascending.
  const std::vector<uint32_t>& BlocksOf(uint32_t turn) const;
  // The iteration, of a training of `iterations`, with which a round ends (0: the whole scene's
  // turn): a multiple of the batch or, of the last one, `iterations`.
  int EndOfRound(uint32_t round, int iterations, int batch) const;
  // The most blocks of a turn.
  size_t at_once() const;

 private:
  std::vector<std::vector<uint32_t>> blocks_;  // of a round's turns
  uint32_t rounds_ = 2;
};

// Ranks that train a block together: as many groups as there are blocks at once, if there are as
// many ranks, and no more ranks in one than a step has views. Neighbours, which mpirun starts on
// one machine, are in one group.
class BlockGroups {
 public:
  BlockGroups() = default;
  // work: of each block, in any unit. In each turn the block with the most work first goes to the
  // group that has the least.
  BlockGroups(const BlockSchedule& schedule, const std::vector<int>& work, size_t ranks, int batch);

  size_t count() const { return groups_; }
  // Those that have work, from rank 0 on.
  size_t working_ranks() const { return working_; }
  // Of a rank that has work.
  size_t GroupOf(size_t rank) const { return rank * groups_ / working_; }
  size_t OfBlock(size_t block) const { return of_block_[block]; }

 private:
  size_t groups_ = 1, working_ = 1;
  std::vector<size_t> of_block_;
};

}  // namespace cosplat
