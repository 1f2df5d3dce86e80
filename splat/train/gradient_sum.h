// The gradients of a step of several views, summed in the order of the views, whichever rank drew
// them: the bits do not depend on the number of ranks.
//
//   Begin -> Add, once per round of as many views as there are ranks -> gradients, moves -> Adam
//
// A view has gradients in the groups (kGaussianGroup) that it shows something of. Each rank sends
// those of its view to the groups' owners (splat/train/shards.h), who sum them.
#pragma once

#include <vector>

#include "splat/gaussians.h"
#include "splat/train/density.h"
#include "splat/train/shards.h"

namespace cosplat {

// Of one view, for all Gaussians.
struct ViewGradients {
  Gaussians& gradients;       // valid in groups with a visible Gaussian
  Buffer<float>& screen;      // [N, 2] as in WorldGradients
  View<const float> radii;    // [N] 0: not visible
  int width = 0, height = 0;  // px, of the image
  double loss = 0;
};

class GradientSum {
 public:
  GradientSum(Ranks& ranks, const Shards& shards) : ranks_(ranks), shards_(shards) {}

  // views: of the step, whose mean is taken.
  void Begin(const Gaussians& gaussians, size_t views);
  // Adds a round's views, view r of which rank r has drawn. mine: null if this rank has none, in
  // the last round. statistics: null if they are not gathered.
  void Add(const ViewGradients* mine, const Gaussians& gaussians, DensityStatistics* statistics);

  // Mean over the views, in the own groups that `moves` names; elsewhere any values.
  Gaussians& gradients() { return sum_; }
  // [N] positive for Gaussians of the own groups that are visible in a view.
  const Buffer<float>& moves() const { return moves_; }
  // Instead: all Gaussians of the own groups.
  void MoveAll();
  // Sets the gradients of own groups without a visible Gaussian to 0, for those who move them too.
  void ZeroUnseen();
  // Sets `moves` ([N]) to 0 in other ranks' groups.
  void KeepOwn(View<float> moves) const;
  // Of the views in their order. Not finite if one is not.
  double MeanLoss() const;
  // Groups that this rank's views showed something of, since the start.
  size_t groups_drawn() const { return groups_drawn_; }

  void Release();
  size_t held() const;  // bytes

 private:
  struct Rows;
  void AddView(const Rows& view, const Gaussians& gaussians, DensityStatistics* statistics);

  Ranks& ranks_;
  const Shards& shards_;
  Gaussians sum_;
  Buffer<float> moves_;
  Buffer<uint8_t> seen_;  // [groups] whether `sum_` is set
  float share_ = 1;       // one over the number of views
  std::vector<double> losses_;
  std::vector<std::vector<uint32_t>> groups_;  // drawn, by owner
  std::vector<Message> to_, from_;
  size_t groups_drawn_ = 0;
};

}  // namespace cosplat
