#include "splat/train/step/gradient_sum.h"

#include <algorithm>
#include <vector>

#include "splat/device/for_each.h"
#include "splat/train/ranks/kernels/shards.h"
#include "splat/train/ranks/shards.h"

namespace cosplat {

void GradientSum::Begin(const Gaussians& gaussians, size_t views) {
  sum_.RefillLike(gaussians, stream_);
  update_mask_.Refill(gaussians.size(), stream_);
  update_mask_.FillWithZeros(stream_);
  seen_.Refill(GroupCount(gaussians.size()), stream_);
  seen_.FillWithZeros(stream_);
  never_.Refill(1, stream_);
  never_.FillWithZeros(stream_);
  of_view_ = 1 / float(views);
}

void GradientSum::Add(const ViewGradients& view,
                      size_t first,
                      const Gaussians& gaussians,
                      DensityStatistics* statistics) {
  AccumulateStep accumulate{view.radii,
                            view.screen,
                            std::as_const(view.gradients.values[kScaleLog]).view(),
                            gaussians.values[kScaleLog].view(),
                            view.width,
                            view.height,
                            {},
                            {},
                            {},
                            never_.data()};
  if (statistics) {
    accumulate.screen_gradient = statistics->screen_gradient.view();
    accumulate.plasticity = statistics->plasticity.view();
    accumulate.visible = statistics->visible.view();
  }
  const size_t groups = GroupCount(view.radii.size()), first_group = first / kGaussianGroup;
  ForEachGroup(groups,
               stream_,
               AddGroup{RowsOf(view.gradients),
                        RowsOf(sum_),
                        view.radii,
                        first_group,
                        gaussians.size(),
                        std::as_const(seen_).view(),
                        of_view_,
                        update_mask_.view(),
                        statistics != nullptr,
                        accumulate});
  ForEach(groups, stream_, MarkSeen{view.radii, first_group, seen_.view()});
}

void GradientSum::ZeroUnseen() {
  ForEachGroup(seen_.size(),
               stream_,
               ZeroUnseenGroup{RowsOf(sum_), update_mask_.size(), std::as_const(seen_).view()});
}

size_t GradientSum::CountSeen() const {
  const std::vector<uint8_t> seen = seen_.Downloaded(stream_);
  return size_t(std::count(seen.begin(), seen.end(), uint8_t(1)));
}

void GradientSum::Release() {
  sum_ = {};
  update_mask_ = {};
  seen_ = {};
}

}  // namespace cosplat
