// What a training in blocks (block_training.h) keeps on disk, in the run's folder, where all ranks
// find it:
//   blocks/whole.bin              the whole scene, until it is split
//   blocks/N.bin                  a block's Gaussians after its last round, from 1
//   blocks/N.record.bin           what that round came to; blocks/whole.record.bin likewise
//   blocks/N.round-R.bin          checkpoint of its training in round R
//   blocks/N/V.rgba               its layer in training view V (splat/train/blocks/layers.h),
//   [height,
//                                 width, 4] without a header; one byte: nothing is there
//   blocks/whole/V.rgba           all blocks there, as the finished scene draws them
// and while block N is in training, read in every step:
//   blocks/N/V.front.rgba         what others show in front of it
//   blocks/N/V.behind.rgba        and behind it
//   blocks/N/V.target.rgba        what it is trained towards (splat/train/blocks/block_target.h)
//   blocks/N/V.ignored            [height, width]: not 0 where it is not
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/base/state_file.h"
#include "splat/gaussians.h"
#include "splat/train/blocks/blocks.h"
#include "splat/train/loss/photograph.h"
#include "splat/train/trainer.h"

namespace cosplat {

constexpr size_t kWholeScene = size_t(-1);  // in place of a block

struct RoundCost {
  uint64_t steps = 0, ignored = 0;
  double seconds = 0, cpu_seconds = 0;
  double ms_per_step = 0;  // at the end; of a sum, of what was added last
  PhaseTimes times;
  RoundCost& operator+=(const RoundCost& other);
};

// What an image shows of a block in a view.
enum class LayerKind { kOwn, kFront, kBehind, kTarget, kIgnored };

// What a block's last round came to.
struct BlockRecord {
  uint32_t round = 0;  // the last one; 0: none
  uint64_t gaussians = 0;
  RoundCost cost;
  ExposureState exposures;  // of the views that it trains on; empty unless they are trained
};

class BlockFiles {
 public:
  // layout: of all Gaussians, with none of them.
  BlockFiles(const std::string& run_folder, const Gaussians& layout);

  // All functions throw Error if a file cannot be written, is missing or is damaged. The record is
  // written last.
  void WriteBlock(size_t block, const Gaussians& gaussians, const BlockRecord& record) const;
  Gaussians ReadBlock(size_t block) const;
  Gaussians ReadBlocks(const std::vector<uint32_t>& blocks) const;  // one after another
  BlockRecord ReadRecord(size_t block) const;
  void RemoveWhole() const;
  void WriteLayer(size_t block, size_t view, LayerKind kind, const Image8& layer) const;
  Image8 ReadLayer(size_t block, size_t view, LayerKind kind, const Camera& camera) const;
  void RemoveLayer(size_t block, size_t view, LayerKind kind) const;
  std::string CheckpointPath(size_t block, uint32_t round) const;

  // Makes the folder; removes it with all that is in it.
  static void Make(const std::string& run_folder);
  static void Remove(const std::string& run_folder);

 private:
  std::string PathOf(size_t block, const std::string& suffix) const;
  std::string LayerPath(size_t block, size_t view, LayerKind kind) const;

  std::string folder_;
  Gaussians layout_;
};

// How far a training in blocks is, and what all its blocks have in common: the same on all ranks,
// and what the run's checkpoint has.
struct BlockState {
  explicit BlockState(size_t count) : views(count), counts(count, 0) {}

  uint32_t round = 0;  // 0: the whole scene's, in which there is nothing else yet
  RoundCost cost;      // of all rounds before this one
  SceneBlocks blocks;
  std::vector<std::vector<uint32_t>> views;  // that each block is trained on
  std::vector<uint64_t> counts;              // Gaussians of each block
  ExposureState exposures;                   // of all frames; empty unless they are trained

  // frames: of the scene. Reading throws Error if it does not fit them.
  void Serialize(StateArchive& archive, size_t frames, bool has_exposures);
};

}  // namespace cosplat
