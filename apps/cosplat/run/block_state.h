// How far a training in blocks (block_training.h) is, and what all its blocks have in common: the
// same on all ranks, and what the run's checkpoint has.
#pragma once

#include <cstdint>
#include <vector>

#include "apps/cosplat/run/block_files.h"
#include "splat/base/state_file.h"
#include "splat/train/blocks/blocks.h"
#include "splat/train/loss/photograph.h"

namespace cosplat {

struct BlockState {
  explicit BlockState(size_t count) : views(count), counts(count, 0) {}

  uint32_t round = 0;  // 0: the whole scene's, in which there is nothing else yet
  RoundCost cost;      // of all rounds before this one
  SceneBlocks blocks;
  std::vector<std::vector<uint32_t>> views;  // that each block is trained on
  std::vector<uint64_t> counts;              // Gaussians of each block
  ExposureState exposures;                   // of all frames; empty unless they are trained

  // frames: of the scene. Reading throws Error if it does not fit them.
  void Describe(StateArchive& archive, size_t frames, bool has_exposures);
};

}  // namespace cosplat
