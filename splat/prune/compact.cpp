// Compact-3DGS's hard mask (splat/train/kernels/prune_mask.h). What it hides goes at each
// densification and, afterwards, every 1,000 of 30,000 steps and at the end.
#include "splat/prune/learned_mask.h"
#include "splat/prune/rounds.h"
#include "splat/prune/rules.h"
#include "splat/train/kernels/prune_mask.h"

namespace cosplat {
namespace {

constexpr float kFirst = 1, kRate = 0.01f;
constexpr float kMaskWeight = 5e-4f;  // of photographs; 4e-3 for synthetic scenes

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
      if (math::MaskHides(mask_[i])) opacity_logit_[i] = math::kHiddenLogit;
    world.opacity_logit = opacity_logit_.data();
  }

  double AfterBackward(const Gaussians& gaussians,
                       Gaussians& gradients,
                       View<const float> radii) override {
    d_mask_.assign(mask_.size(), 0.0f);
    const float share = weight_ / float(mask_.size());
    double sum = 0;
    for (size_t i = 0; i < mask_.size(); ++i) {
      sum += math::Sigmoid(mask_[i]);
      d_mask_[i] = math::HardMaskVjp(mask_[i],
                                     share,
                                     radii[i] > 0,
                                     gradients.at(kScaleLog, i),
                                     *gradients.at(kOpacityLogit, i),
                                     *gaussians.at(kOpacityLogit, i));
    }
    mask_.Step(d_mask_);
    return sum * share;
  }

  MaskInSteps Mask() override { return {MaskKind::kHard, weight_, &mask_, nullptr}; }
  void Gather(const Reordering& order) override { mask_.Gather(order); }
  size_t Held() const override { return mask_.Held() + HeldBy(opacity_logit_, d_mask_); }

  PruneRound Rank(const PruneContext&) override {
    PruneRound round;
    for (size_t i = 0; i < mask_.size(); ++i) {
      round.score.push_back(mask_[i]);
      round.remove += math::MaskHides(mask_[i]);
    }
    return round;
  }

 private:
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
