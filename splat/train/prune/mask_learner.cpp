#include "splat/train/prune/mask_learner.h"

#include <algorithm>

#include "splat/device/buffer.h"
#include "splat/device/for_each.h"
#include "splat/device/gather.h"
#include "splat/device/sum_tree.h"
#include "splat/train/prune/kernels/prune_mask.h"

namespace cosplat {
namespace {

constexpr double kMaskEps = 1e-15;  // of the mask's Adam

}  // namespace

void MaskLearner::Upload(const MaskInSteps& mask, Stream& stream) {
  mask_ = mask;
  if (!learns()) return;
  const LearnedMask& learned = *mask.learned;
  step_ = learned.step;
  mu_.Upload(learned.value.data(), learned.size(), stream);
  m_.Upload(learned.m.data(), learned.size(), stream);
  v_.Upload(learned.v.data(), learned.size(), stream);
  if (mask.importance) importance_.Upload(mask.importance->data(), learned.size(), stream);
}

void MaskLearner::Download(Stream& stream) {
  if (!learns()) return;
  LearnedMask& learned = *mask_.learned;
  learned.step = step_;
  const auto bring = [&](const Buffer<float>& from, std::vector<float>& to) {
    to.resize(from.size());
    from.Download(to.data(), stream);
  };
  bring(mu_, learned.value);
  bring(m_, learned.m);
  bring(v_, learned.v);
  if (mask_.importance) bring(importance_, *mask_.importance);
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
  const View<const float> mu = std::as_const(mu_).view();
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
                    math::AdamStepAt(mask_.learned->rate, kMaskEps, ++step_),
                    radii,
                    std::as_const(importance_).view(),
                    shown,
                    std::as_const(opacity_logit_).view(),
                    gaussians.values[kOpacityLogit].view(),
                    std::as_const(gradients.values[kScaleLog]).view(),
                    overflowed,
                    gradients.values[kOpacityLogit].view(),
                    mu_.view(),
                    m_.view(),
                    v_.view()});
  value_.Refill(1, stream);
  ForEach(1, stream, AddUpShown{SumInTree(ShownMasks{shown}, sums_, stream), share, value_.data()});
}

void MaskLearner::Gather(View<const uint32_t> source, size_t first_fresh, Stream& stream) {
  if (!learns()) return;
  GatherRows(mu_, spare_, 1, source, source.count, stream);
  if (mask_.importance) GatherRows(importance_, spare_, 1, source, source.count, stream);
  for (Buffer<float>* moments : {&m_, &v_})
    GatherRows(*moments, spare_, 1, source, first_fresh, stream);
}

size_t MaskLearner::held() const {
  return HeldBy(mu_, m_, v_, importance_, shown_, opacity_logit_, spare_);
}

}  // namespace cosplat
