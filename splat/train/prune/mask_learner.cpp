#include "splat/train/prune/mask_learner.h"

#include <algorithm>

#include "splat/device/arrays.h"
#include "splat/device/for_each.h"
#include "splat/device/gather.h"
#include "splat/device/sum_tree.h"
#include "splat/train/prune/kernels/prune_mask.h"

namespace cosplat {

void MaskLearner::Upload(const MaskInSteps& mask, Stream& stream) {
  mask_ = mask;
  if (!learns()) return;
  now_.step = mask.learned->step;
  UploadArrays(*mask.learned, now_, stream);
  if (mask.importance) importance_.Upload(*mask.importance, stream);
}

void MaskLearner::Download(Stream& stream) {
  if (!learns()) return;
  mask_.learned->step = now_.step;
  DownloadArrays(now_, *mask_.learned, stream);
  if (mask_.importance) importance_.Download(*mask_.importance, stream);
  stream.Wait();
}

uint64_t MaskLearner::DrawsOf(size_t gaussians) const {
  return learns() && mask_.kind == MaskKind::kSoft ? math::kMaskDraws * uint64_t(gaussians) : 0;
}

void MaskLearner::BeforeDraw(const Gaussians& gaussians,
                             Rng rng,
                             WorldGaussians& world,
                             Stream& stream) {
  const size_t n = gaussians.size();
  const View<const float> logits = gaussians.values[kOpacityLogit].view();
  const View<const float> mu = std::as_const(now_.value).view();
  shown_.Refill(n, stream);
  opacity_logit_.Refill(n, stream);
  if (mask_.kind == MaskKind::kHard)
    ForEach(n, stream, HideMasked{mu, logits, shown_.view(), opacity_logit_.view()});
  else
    ForEach(n,
            stream,
            DimMasked{mu,
                      std::as_const(importance_).view(),
                      logits,
                      rng,
                      shown_.view(),
                      opacity_logit_.view()});
  world.opacity_logit = opacity_logit_.data();
}

void MaskLearner::AfterBackward(const Gaussians& gaussians,
                                View<const float> radii,
                                const uint32_t* overflowed,
                                Gaussians& gradients,
                                Stream& stream) {
  const size_t n = gaussians.size();
  const float share = mask_.weight / float(n);
  const View<const float> shown = std::as_const(shown_).view();
  ForEach(n,
          stream,
          LearnMask{mask_.kind,
                    share,
                    math::AdamStepAt(mask_.learned->rate, ++now_.step),
                    radii,
                    std::as_const(importance_).view(),
                    shown,
                    std::as_const(opacity_logit_).view(),
                    gaussians.values[kOpacityLogit].view(),
                    std::as_const(gradients.values[kScaleLog]).view(),
                    overflowed,
                    gradients.values[kOpacityLogit].view(),
                    now_.value.view(),
                    now_.m.view(),
                    now_.v.view()});
  value_.Refill(1, stream);
  ForEach(1, stream, AddUpShown{SumInTree(ShownMasks{shown}, sums_, stream), share, value_.data()});
}

void MaskLearner::Gather(View<const uint32_t> source, size_t first_fresh, Stream& stream) {
  if (!learns()) return;
  GatherRows(now_.value, spare_, 1, source, source.count, stream);
  if (mask_.importance) GatherRows(importance_, spare_, 1, source, source.count, stream);
  for (Buffer<float>* moments : {&now_.m, &now_.v})
    GatherRows(*moments, spare_, 1, source, first_fresh, stream);
}

size_t MaskLearner::allocated_bytes() const {
  return AllocatedByArrays(now_) + AllocatedBytes(importance_, shown_, opacity_logit_, spare_);
}

}  // namespace cosplat
