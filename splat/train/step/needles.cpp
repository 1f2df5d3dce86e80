#include "splat/train/step/needles.h"

#include <cmath>
#include <utility>

#include "splat/device/for_each.h"
#include "splat/device/sum_tree.h"

namespace cosplat {

View<const float> NeedleRegularizer::Backward(const Gaussians& gaussians,
                                              View<const float> visible,
                                              size_t count,
                                              Shards& shards,
                                              Gaussians& gradients) {
  const size_t n = gaussians.size();
  const NeedleRule rule{std::log(settings_.limit), std::log(settings_.ratio)};
  const View<const float> scale_log = gaussians.values[kScaleLog].view();
  total_.Refill(1, stream_);
  updated_.Refill(n, stream_);
  ForEach(1,
          stream_,
          AddUpNeedles{Sum({rule, scale_log}, count, shards), settings_.weight, total_.data()});
  ForEach(n,
          stream_,
          NeedlesBackward{rule,
                          scale_log,
                          visible,
                          total_.data(),
                          gradients.values[kScaleLog].view(),
                          updated_.view()});
  return std::as_const(updated_).view();
}

View<const NeedleSum> NeedleRegularizer::Sum(const NeedleLengths& own,
                                             size_t count,
                                             Shards& shards) {
  if (!shards.divides()) return SumInTree(own, sums_, stream_);
  static_assert(kRowsPerBlock % kSumBlock == 0);
  sums_.Refill(SumBlockCount(own.size()), stream_);
  ForEach(sums_.size(), stream_, SumBlocks<NeedleLengths>{own, sums_.view()});
  Buffer<NeedleSum> sums(sums_.Downloaded(stream_));
  sums = shards.Assembled(sums, {0, count, 1, kSumBlock}, ForWhom::kAllRanks);
  all_sums_.Upload(sums, stream_);
  stream_.Wait();
  return SumInTree(std::as_const(all_sums_).view(), sums_, stream_);
}

}  // namespace cosplat
