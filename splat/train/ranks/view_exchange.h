// Views drawn from Gaussians that are divided between ranks (splat/train/ranks/shards.h), a round
// of as many views as there are ranks at a time: rank r draws view r. Source: Grendel-GS (Zhao et
// al. 2024, section 3).
//
//   each rank projects its Gaussians for every view -> the rank that draws a view gets what shows
//   in it -> draws, and differentiates -> the gradients of what was drawn go back -> each rank has
//   those of its Gaussians, view by view
//
// What is sent: groups (kGaussianGroup) with a visible Gaussian. A rank lists what it gets in the
// order of all Gaussians, so that it draws the same bits as if it had them all.
#pragma once

#include <functional>
#include <vector>

#include "splat/base/camera.h"
#include "splat/render/rasterizer.h"
#include "splat/train/ranks/rank_messages.h"
#include "splat/train/ranks/row_share.h"

namespace cosplat {

// Gaussians whose gradients are in memory at a time.
constexpr size_t kRowsPerPart = size_t(1) << 16;

struct RoundView {
  Camera camera;
  int degree = 0;  // of the colours
};

class ViewExchange {
 public:
  // Everything is in the memory of the rasteriser's stream.
  ViewExchange(Ranks& ranks, StagedRasterizer& rasterizer);

  // All ranks call both, for each round, with the same views; the last round may have fewer than
  // there are ranks.

  // own: this rank's Gaussians, valid until Return. Fills the tape of a rank that has a view.
  void Project(const WorldGaussians& own,
               Basis basis,
               std::vector<RoundView> views,
               RenderTape& tape);
  // Gradients of a view's splats, for own Gaussians [first, first + part.count).
  struct Part {
    const RoundView& view;
    size_t first;
    WorldGaussians gaussians;
    const ProjectedSplat* splats;
    View<const float> radii;
    const SplatGradient* d_splats;  // valid where radii > 0
  };
  // tape: after DrawBackward, if this rank has a view. Calls take(part) for parts of the own
  // Gaussians, for each in the order of the views that show something of it.
  void Return(const RenderTape& tape, const std::function<void(const Part&)>& take);

  // Own groups that views showed something of, since the start.
  size_t groups_drawn() const { return groups_drawn_; }
  void Release();
  // Bytes, of what grows with the Gaussians and with what views show of them.
  size_t allocated_bytes() const;

 private:
  // The own groups that have a visible Gaussian.
  std::vector<uint32_t> DrawnGroups(View<const float> radii);
  void Receive(RenderTape& tape);
  void ReturnPart(size_t view, size_t first, size_t count, const std::function<void(const Part&)>&);
  bool has_view() const { return ranks_.rank() < views_.size(); }

  Ranks& ranks_;
  StagedRasterizer& rasterizer_;
  Stream& stream_;
  RowShare share_;
  RankMessages messages_;
  WorldGaussians own_;
  std::vector<RoundView> views_;
  // By the view that they are sent for, until Return: own groups, and the same in the stream's
  // memory.
  std::vector<std::vector<uint32_t>> groups_;
  std::vector<Buffer<uint32_t>> lists_;
  std::vector<Message> splats_, gradients_;
  // By the rank that they come from: their places among the groups of the tape.
  std::vector<Buffer<uint32_t>> places_;
  // All own Gaussians or, when gradients are returned, a part of them.
  Buffer<ProjectedSplat> projected_;
  Buffer<float> radii_;
  Buffer<SplatGradient> d_splats_;
  Buffer<uint8_t> drawn_;  // [groups]
  size_t groups_drawn_ = 0;
};

// What ranks exchange (splat/train/ranks/ranks.h), counted since the start or since resuming, over
// all of them.
struct ExchangeStatistics {
  size_t ranks = 1;
  uint64_t steps = 0;           // of several views
  uint64_t views = 0;           // of those
  uint64_t groups_drawn = 0;    // summed over views: with a visible Gaussian
  uint64_t groups_updated = 0;  // summed over steps: with one that is visible in a view
  uint64_t assembled = 0;       // numbers of Gaussians that all ranks were to have
  uint64_t handed_over = 0;     // numbers of Gaussians that changed hands, and for checkpoints
  uint64_t bytes_sent = 0;
  double seconds = 0;  // mean over the ranks, waiting included
};

}  // namespace cosplat
