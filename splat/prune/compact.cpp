// Compact-3DGS (Lee et al. 2024, section 4.1): a mask 1[sigma(mu) > 0.01] on opacity and scale,
// learned with a straight-through gradient; loss weight * mean sigma(mu). What it hides goes at
// each densification and, afterwards, every 1,000 of 30,000 steps and at the end.
#include <cmath>

#include "splat/math/scalar.h"
#include "splat/prune/learned_mask.h"
#include "splat/prune/rounds.h"
#include "splat/prune/rules.h"

namespace cosplat {
namespace {

constexpr float kThreshold = 0.01f, kFirst = 1, kRate = 0.01f;
constexpr float kMaskWeight = 5e-4f;  // of photographs; 4e-3 for synthetic scenes
constexpr float kHidden = -100;       // an opacity's logit

class CompactPruner : public Pruner {
 public:
  CompactPruner(const PruneSettings& settings,
                const Schedule& schedule,
                int iterations,
                size_t gaussians)
      : weight_(settings.mask_weight > 0 ? settings.mask_weight : kMaskWeight),
        schedule_(schedule),
        iterations_(iterations),
        late_(PruneRounds::Scaled(iterations, 15000, 1000, 30000)),
        mask_(gaussians, kFirst, kRate) {}

  bool PrunesAt(int iteration) const override {
    return schedule_.DensifiesAt(iteration) || late_.At(iteration) || iteration == iterations_;
  }

  void BeforeDraw(const Gaussians& gaussians, WorldGaussians& world, Rng&) override {
    const Buffer<float>& logits = gaussians.values[kOpacityLogit];
    opacity_logit_.assign(logits.begin(), logits.end());
    for (size_t i = 0; i < mask_.size(); ++i)
      if (Hides(i)) opacity_logit_[i] = kHidden;
    world.opacity_logit = opacity_logit_.data();
  }

  // With the mask m = 1: d_m = dL/ds . s + dL/do o, the derivatives by log s and logit o being at
  // hand. What is hidden was not drawn and has none.
  double AfterBackward(const Gaussians& gaussians,
                       Gaussians& gradients,
                       View<const float> radii) override {
    d_mask_.assign(mask_.size(), 0.0f);
    const float share = weight_ / float(mask_.size());
    double sum = 0;
    for (size_t i = 0; i < mask_.size(); ++i) {
      const float soft = math::Sigmoid(mask_[i]);
      sum += soft;
      float d = share;
      if (radii[i] > 0) {
        const float* d_s = gradients.at(kScaleLog, i);
        // 1 / (1 - o) = 1 + e^logit.
        d += d_s[0] + d_s[1] + d_s[2] +
             gradients.at(kOpacityLogit, i)[0] * (1 + std::exp(gaussians.at(kOpacityLogit, i)[0]));
      }
      d_mask_[i] = d * soft * (1 - soft);
    }
    mask_.Step(d_mask_);
    return sum * share;
  }

  void Gather(const Reordering& order) override { mask_.Gather(order); }
  size_t Held() const override { return mask_.Held() + HeldBy(opacity_logit_, d_mask_); }

  PruneRound Rank(const PruneContext&) override {
    PruneRound round;
    for (size_t i = 0; i < mask_.size(); ++i) {
      round.score.push_back(mask_[i]);
      round.remove += Hides(i);
    }
    return round;
  }

 private:
  bool Hides(size_t i) const { return math::Sigmoid(mask_[i]) <= kThreshold; }

  float weight_;
  Schedule schedule_;
  int iterations_;
  PruneRounds late_;
  LearnedMask mask_;
  Buffer<float> opacity_logit_;
  std::vector<float> d_mask_;
};

}  // namespace

std::unique_ptr<Pruner> MakeCompactPruner(const PruneSettings& settings,
                                          const Schedule& schedule,
                                          int iterations,
                                          size_t gaussians) {
  return std::make_unique<CompactPruner>(settings, schedule, iterations, gaussians);
}

}  // namespace cosplat
