#include "splat/device/cuda/gather_rows.cuh"
#include "splat/device/memory_part.h"
#include "splat/train/cuda/mask_learner.h"
#include "splat/train/kernels/prune_mask.h"

namespace cosplat::cuda {
namespace {

struct HideMasked {
  DeviceView<const float> mu, opacity_logit;
  DeviceView<float> shown, drawn_logit;
  __device__ void operator()(size_t i) const {
    shown[i] = math::Sigmoid(mu[i]);
    drawn_logit[i] = math::MaskHides(mu[i]) ? math::kHiddenLogit : opacity_logit[i];
  }
};

struct DimMasked {
  DeviceView<const float> mu, importance, opacity_logit;
  Rng rng;
  DeviceView<float> shown, drawn_logit;
  __device__ void operator()(size_t i) const {
    Rng mine = rng.After(i * math::kMaskDraws);
    const math::SoftMask soft = math::SoftMaskOf(mu[i], importance[i], opacity_logit[i], mine);
    shown[i] = soft.mask;
    drawn_logit[i] = soft.opacity_logit;
  }
};

// One step of the mask's Adam.
struct LearnMask {
  MaskKind kind;
  float share;
  math::AdamStep adam;
  DeviceView<const float> radii, importance, shown, drawn_logit, opacity_logit, d_scale_log;
  const uint32_t* overflowed;
  DeviceView<float> d_opacity_logit, mu, m, v;
  __device__ void operator()(size_t i) const {
    if (*overflowed != 0) return;
    const float d = Gradient(i);
    math::AdamUpdate(adam, std::isfinite(d) ? d : 0.0f, mu[i], m[i], v[i]);
  }
  __device__ float Gradient(size_t i) const {
    const bool drawn = radii[i] > 0;
    if (kind == MaskKind::kHard)
      return math::HardMaskVjp(
          mu[i], share, drawn, &d_scale_log[3 * i], d_opacity_logit[i], opacity_logit[i]);
    return math::SoftMaskVjp({shown[i], drawn_logit[i]},
                             importance[i],
                             share,
                             drawn,
                             opacity_logit[i],
                             d_opacity_logit[i]);
  }
};

// Of each block of 256, in order.
struct SumShown {
  static constexpr size_t kBlock = 256;
  DeviceView<const float> shown;
  DeviceView<double> sums;
  __device__ void operator()(size_t b) const {
    double sum = 0;
    for (size_t i = b * kBlock; i < math::Min((b + 1) * kBlock, shown.count); ++i) sum += shown[i];
    sums[b] = sum;
  }
};

struct AddUpShown {
  DeviceView<const double> sums;
  float share;
  double* value;
  __device__ void operator()(size_t) const {
    double sum = 0;
    for (size_t b = 0; b < sums.count; ++b) sum += sums[b];
    *value = sum * share;
  }
};

}  // namespace

void MaskLearner::Upload(const MaskInSteps& mask, cudaStream_t stream) {
  mask_ = mask;
  if (!learns()) return;
  const LearnedMask& learned = *mask.learned;
  step_ = learned.step;
  mu_.Upload(learned.value.data(), learned.size(), stream);
  m_.Upload(learned.m.data(), learned.size(), stream);
  v_.Upload(learned.v.data(), learned.size(), stream);
  if (mask.importance) importance_.Upload(mask.importance->data(), learned.size(), stream);
}

void MaskLearner::Download(cudaStream_t stream) {
  if (!learns()) return;
  LearnedMask& learned = *mask_.learned;
  learned.step = step_;
  const auto bring = [&](const DeviceBuffer<float>& from, std::vector<float>& to) {
    to.resize(from.size());
    from.Download(to.data(), stream);
  };
  bring(mu_, learned.value);
  bring(m_, learned.m);
  bring(v_, learned.v);
  if (mask_.importance) bring(importance_, *mask_.importance);
  Check(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
}

uint64_t MaskLearner::DrawsOf(size_t gaussians) const {
  return learns() && mask_.kind == MaskKind::kSoft ? math::kMaskDraws * uint64_t(gaussians) : 0;
}

void MaskLearner::BeforeDraw(const DeviceGaussians& gaussians,
                             Rng rng,
                             WorldGaussians& world,
                             cudaStream_t stream) {
  const size_t n = gaussians.size();
  const DeviceView<const float> logits = gaussians.values[kOpacityLogit].view();
  const DeviceView<const float> mu = std::as_const(mu_).view();
  shown_.Refill(n);
  opacity_logit_.Refill(n);
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

void MaskLearner::AfterBackward(const DeviceGaussians& gaussians,
                                DeviceView<const float> radii,
                                const uint32_t* overflowed,
                                DeviceGaussians& gradients,
                                cudaStream_t stream) {
  const size_t n = gaussians.size();
  const float share = mask_.weight / float(n);
  const DeviceView<const float> shown = std::as_const(shown_).view();
  ForEach(n,
          stream,
          LearnMask{mask_.kind,
                    share,
                    MaskAdamStep(mask_.learned->rate, ++step_),
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
  sums_.Refill((n + SumShown::kBlock - 1) / SumShown::kBlock);
  value_.Refill(1);
  ForEach(sums_.size(), stream, SumShown{shown, sums_.view()});
  ForEach(1, stream, AddUpShown{std::as_const(sums_).view(), share, value_.data()});
}

void MaskLearner::Gather(DeviceView<const uint32_t> source,
                         size_t first_fresh,
                         cudaStream_t stream) {
  if (!learns()) return;
  GatherArray(mu_, spare_, 1, source, source.count, stream);
  if (mask_.importance) GatherArray(importance_, spare_, 1, source, source.count, stream);
  for (DeviceBuffer<float>* moments : {&m_, &v_})
    GatherArray(*moments, spare_, 1, source, first_fresh, stream);
}

size_t MaskLearner::held() const {
  return HeldBy(mu_, m_, v_, importance_, shown_, opacity_logit_, spare_);
}

}  // namespace cosplat::cuda
