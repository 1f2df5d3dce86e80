// Trains a scene in blocks, one after another, for `train-scene --blocks`.
//
// First the whole scene is trained with as many Gaussians as a block may have, on the small images
// that training begins with; by their places it is split (splat/train/blocks.h). Each block is then
// trained between what the others show in each view (splat/train/layers.h), in rounds, so that all
// of them see what became of their neighbours. A Gaussian belongs to one block from then on: the
// scene is all of them together, and has no seams to be cut.
//
// While this goes on its files are in the run's folder (block_files.h). A checkpoint has the block
// that is in training; one is written before any of these files changes, so that from the last one
// the same bits follow.
#pragma once

#include <functional>
#include <vector>

#include "apps/cosplat/options/scene_options.h"
#include "apps/cosplat/run/run_checkpoint.h"
#include "apps/cosplat/run/scene_start.h"
#include "splat/base/skipped.h"
#include "splat/eval/lpips.h"
#include "splat/train/scene_subject.h"

namespace cosplat {

struct BlockHooks {
  Lpips* lpips = nullptr;  // measures the held-out images; null: none
  std::function<void(const ExposureState&)> save_exposures;  // empty: none are trained
  // Of the whole scene; empty: nothing held out.
  std::function<void(const Gaussians&)> evaluate;
};

// As RunTraining (train_run.h), but for the checkpoint and the milestones that there are none of,
// and saves the splats itself. options.max_gaussians: of one block. start: of the whole scene. The
// checkpoint and the blocks' files are left to the caller.
void TrainInBlocks(const SceneTrainOptions& options,
                   SceneStart start,
                   SceneSubject& scene,
                   const std::vector<SkippedFrame>& skipped,
                   const BlockHooks& hooks,
                   RunCheckpoint& checkpoint);

}  // namespace cosplat
