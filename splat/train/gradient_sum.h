// The gradients of a step of several views, summed in the order of the views, whichever rank drew
// them: the bits do not depend on the number of ranks.
//
//   Begin -> Add, once per round of as many views as there are ranks -> gradients, moves -> Adam
//
// A view has gradients in the groups (kGaussianGroup) that it shows something of. Each rank sends
// those of its view to the groups' owners (splat/train/row_share.h), who sum them.
#pragma once

#include <optional>
#include <vector>

#include "splat/gaussians.h"
#include "splat/train/density.h"
#include "splat/train/rank_messages.h"
#include "splat/train/row_share.h"

namespace cosplat {

struct ViewLoss {
  double loss = 0;
  int width = 0, height = 0;  // px, of the image
};

// Of one view, for all Gaussians, in the stream's memory.
struct ViewGradients {
  Gaussians& gradients;     // valid in groups with a visible Gaussian
  Buffer<float>& screen;    // [N, 2] as in WorldGradients
  View<const float> radii;  // [N] 0: not visible
  ViewLoss of;
};

class GradientSum {
 public:
  // In the memory of `stream`, on which everything runs.
  GradientSum(Ranks& ranks, Stream& stream);

  // views: of the step, whose mean is taken.
  void Begin(const Gaussians& gaussians, size_t views);
  // Adds a round's views, view r of which rank r has drawn. mine: null if this rank has none, in
  // the last round. statistics: null if they are not gathered.
  void Add(const ViewGradients* mine, const Gaussians& gaussians, DensityStatistics* statistics);

  // [own rows] mean over the views, in the groups that `moves` names; elsewhere any values.
  Gaussians& gradients() { return sum_; }
  // [N] positive for Gaussians of the own groups that are visible in a view.
  const Buffer<float>& moves() const { return moves_; }
  // Sets the gradients of own groups without a visible Gaussian to 0, for those who move them too.
  void ZeroUnseen();
  // Of the views in their order. Not finite if one is not.
  double MeanLoss() const;
  // Groups that this rank's views showed something of, since the start.
  size_t groups_drawn() const { return groups_drawn_; }

  void Release();
  // Bytes.
  size_t held() const { return HeldBy(sum_) + HeldBy(moves_, seen_, drawn_); }
  size_t HeldByMessages() const { return messages_.held(); }

 private:
  struct Rows;
  std::vector<std::optional<ViewLoss>> ExchangeLosses(const ViewGradients* mine);
  // Whether this rank's view shows something of each group.
  std::vector<uint8_t> DrawnGroups(const ViewGradients& mine);
  void AddView(const Rows& view, const Gaussians& gaussians, DensityStatistics* statistics);

  Ranks& ranks_;
  Stream& stream_;
  RowShare share_;
  Gaussians sum_;
  Buffer<float> moves_;
  Buffer<uint8_t> seen_;   // [groups] whether `sum_` is set
  Buffer<uint8_t> drawn_;  // [groups]
  float of_view_ = 1;      // one over the number of views
  std::vector<double> losses_;
  std::vector<std::vector<uint32_t>> groups_;  // drawn, of those in exchange, by owner
  std::vector<Buffer<uint32_t>> lists_;        // the same in the stream's memory
  RankMessages messages_;
  Buffer<uint32_t> never_;  // [1] 0: no step of several views overflows
  size_t groups_drawn_ = 0;
};

}  // namespace cosplat
