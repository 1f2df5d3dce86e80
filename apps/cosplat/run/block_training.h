// Trains a scene in blocks, for `train-scene --blocks`: one after another, or at the same time on
// groups of ranks.
//
// First the whole scene is trained with as many Gaussians as a block may have, on the small images
// that training begins with; by their places it is split (splat/train/blocks/blocks.h). Each block
// is then trained between what the others show in each view (splat/train/blocks/layers.h), in
// rounds (splat/train/blocks/block_schedule.h), so that all of them see what became of their
// neighbours. A Gaussian belongs to one block from then on: the scene is all of them together, and
// has no seams to be cut.
//
// While this goes on its files are in the run's folder (block_files.h), which is also how ranks
// hand each other what they have trained. A checkpoint has the round, and each block that is in
// training its own; one is written before any of these files changes, so that from the last ones
// the same bits follow, on any number of ranks.
#pragma once

#include <functional>
#include <vector>

#include "apps/cosplat/options/scene_options.h"
#include "apps/cosplat/run/run_checkpoint.h"
#include "apps/cosplat/run/scene_start.h"
#include "splat/base/skipped.h"
#include "splat/eval/lpips.h"
#include "splat/train/subject/scene_subject.h"

namespace cosplat {

struct BlockHooks {
  Lpips* lpips = nullptr;  // measures the held-out images; null: none
  std::function<void(const ExposureState&)> save_exposures;  // empty: none are trained
  // Evaluates the whole scene; empty: nothing held out.
  std::function<void(const Gaussians&)> evaluate;
};

// As RunTraining (train_run.h), but for the checkpoint and the milestones that there are none of,
// and saves the splats itself. options.max_gaussians: of one block. start: of the whole scene. The
// checkpoint and the blocks' files are left to the caller. All ranks call it; rank 0 alone calls
// the hooks.
void TrainInBlocks(const SceneTrainOptions& options,
                   SceneStart start,
                   SceneSubject& scene,
                   const std::vector<SkippedFrame>& skipped,
                   const BlockHooks& hooks,
                   RunCheckpoint& checkpoint,
                   Ranks& ranks);

}  // namespace cosplat
