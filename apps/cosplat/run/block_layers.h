// What the blocks of a scene show in its training views, on disk (block_files.h), and the views as
// a block is trained on them: between the layers of the others (splat/train/layers.h).
#pragma once

#include <functional>
#include <vector>

#include "apps/cosplat/run/block_files.h"
#include "splat/train/blocks.h"
#include "splat/train/scene_subject.h"

namespace cosplat {

class BlockLayers {
 public:
  // All three must outlive it. blocks may be set later.
  BlockLayers(const BlockFiles& files, SceneSubject& scene, const SceneBlocks& blocks)
      : files_(files), scene_(scene), blocks_(blocks) {}

  // Draws those of a block, of every `step`-th view from `first` on, while goes_on says so.
  void Draw(size_t block, size_t first, size_t step, const std::function<bool()>& goes_on) const;
  // For each block the views of which it covers enough to be trained on them.
  std::vector<std::vector<uint32_t>> ChooseViews() const;

  // For a round of a block, during which the others do not change: puts together what is in front
  // of it and behind it in every `step`-th of these views from the `first` on.
  void PutTogether(size_t block,
                   const std::vector<uint32_t>& views,
                   size_t first,
                   size_t step,
                   const std::function<bool()>& goes_on) const;
  // The views between these, read from disk when they are trained on, towards what the block has to
  // make up for (splat/train/block_target.h). exposures: of these views; empty: identities.
  std::vector<TrainFrame> FramesOf(size_t block,
                                   const std::vector<uint32_t>& views,
                                   const ExposureState& exposures) const;
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
