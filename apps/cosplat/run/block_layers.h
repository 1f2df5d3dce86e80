// What the blocks of a scene show in its training views, on disk (block_files.h), and the views as
// a block is trained on them: between the layers of the others (splat/train/blocks/layers.h).
#pragma once

#include <functional>
#include <vector>

#include "apps/cosplat/run/block_files.h"
#include "splat/train/blocks/blocks.h"
#include "splat/train/subject/scene_subject.h"

namespace cosplat {

class BlockLayers {
 public:
  // All three must outlive it. blocks may be set later.
  BlockLayers(const BlockFiles& files, SceneSubject& scene, const SceneBlocks& blocks)
      : files_(files), scene_(scene), blocks_(blocks) {}

  // Draws those of all blocks, and all of them together, in every `step`-th view from `first` on,
  // while goes_on says so. In memory at a time: the blocks that a view shows.
  void Draw(size_t first, size_t step, const std::function<bool()>& goes_on) const;
  // For each block the views of which it covers enough to be trained on them.
  std::vector<std::vector<uint32_t>> ChooseViews() const;

  // For a round of a block, during which the others do not change: puts together what is in front
  // of it and behind it, and what it is trained towards (splat/train/blocks/block_target.h), in
  // every `step`-th of these views from the `first` on. exposures: of these views; empty:
  // identities.
  void PutTogether(size_t block,
                   const std::vector<uint32_t>& views,
                   const ExposureState& exposures,
                   size_t first,
                   size_t step,
                   const std::function<bool()>& goes_on) const;
  // That, read from disk when it is trained on.
  std::vector<TrainFrame> FramesOf(size_t block, const std::vector<uint32_t>& views) const;
  // After the round.
  void RemoveTogether(size_t block, const std::vector<uint32_t>& views) const;

 private:
  std::vector<uint32_t> OrderIn(size_t view) const {
    return blocks_.FrontToBack(scene_.camera(view).Center());
  }
  Image8 Read(size_t block, size_t view, LayerKind kind = LayerKind::kOwn) const {
    return files_.ReadLayer(block, view, kind, scene_.camera(view));
  }

  const BlockFiles& files_;
  SceneSubject& scene_;
  const SceneBlocks& blocks_;
};

}  // namespace cosplat
