// LP-3DGS (Zhang et al. 2024): for a while a soft mask m = sigma((mu S + g1 - g2) / 0.5) dims each
// opacity, S an importance score (LightGaussian's, its largest 1), g Gumbel noise; loss
// weight * mean m. Then what the mask would rather hide than show (mu S < 0) goes, once.
// 19,500 to 20,000 of 30,000 steps.
#include <algorithm>
#include <cmath>

#include "splat/math/scalar.h"
#include "splat/prune/learned_mask.h"
#include "splat/prune/rules.h"

namespace cosplat {
namespace {

constexpr float kTemperature = 0.5f, kFirst = 1, kRate = 0.05f;
constexpr float kMaskWeight = 5e-4f;
constexpr float kLeast = 1e-6f;  // of a mask and of 1 - opacity: no division by zero

float Gumbel(Rng& rng) {
  return -std::log(-std::log(std::clamp(rng.Uniform(), 1e-7f, 0.9999999f)));
}

class LpPruner : public Pruner {
 public:
  LpPruner(const PruneSettings& settings, int iterations)
      : weight_(settings.mask_weight > 0 ? settings.mask_weight : kMaskWeight),
        begin_(std::max(1, int(int64_t(iterations) * 19500 / 30000))),
        end_(std::max(begin_ + 1, int(int64_t(iterations) * 20000 / 30000))) {}

  bool PrunesAt(int iteration) const override { return iteration == begin_ || iteration == end_; }

  // The first round scores and begins to learn; the second takes away.
  PruneRound Rank(const PruneContext& context) override {
    const size_t n = context.gaussians.size();
    PruneRound round{std::vector<float>(n, 1.0f), {}, 0};
    if (!learning_) {
      importance_ = Significance(context.gaussians, ContributionsIn(context));
      const float most = *std::max_element(importance_.begin(), importance_.end());
      for (float& s : importance_) s /= std::max(most, 1e-30f);
      mu_ = LearnedMask(n, kFirst, kRate);
      learning_ = true;
      return round;
    }
    for (size_t i = 0; i < n; ++i) {
      round.score[i] = mu_[i] * importance_[i];
      round.remove += round.score[i] < 0;
    }
    learning_ = false;
    return round;
  }

  // o' = m o in place of o.
  void BeforeDraw(const Gaussians& gaussians, WorldGaussians& world, Rng& rng) override {
    if (!learning_) return;
    const size_t n = gaussians.size();
    mask_.resize(n);
    opacity_logit_.resize(n);
    for (size_t i = 0; i < n; ++i) {
      const float g1 = Gumbel(rng), g2 = Gumbel(rng);
      const float x = mu_[i] * importance_[i] + g1 - g2;
      mask_[i] = std::max(math::Sigmoid(x / kTemperature), kLeast);
      const float dimmed =
          std::min(mask_[i] * math::Sigmoid(gaussians.at(kOpacityLogit, i)[0]), 1 - kLeast);
      opacity_logit_[i] = std::log(dimmed / (1 - dimmed));
    }
    world.opacity_logit = opacity_logit_.data();
  }

  // From d by the logit of o': d_m = d / (m (1 - o')), d_logit(o) = d (1 - o) / (1 - o').
  double AfterBackward(const Gaussians& gaussians,
                       Gaussians& gradients,
                       View<const float> radii) override {
    if (!learning_) return 0;
    const size_t n = gaussians.size();
    const float share = weight_ / float(n);
    d_mu_.resize(n);
    double sum = 0;
    for (size_t i = 0; i < n; ++i) {
      const float m = mask_[i];
      sum += m;
      float d_mask = share;
      if (radii[i] > 0) {
        float& d = gradients.at(kOpacityLogit, i)[0];
        const float rest = 1 - math::Sigmoid(opacity_logit_[i]);
        d_mask += d / (m * std::max(rest, kLeast));
        d *= (1 - math::Sigmoid(gaussians.at(kOpacityLogit, i)[0])) / std::max(rest, kLeast);
      }
      d_mu_[i] = d_mask * m * (1 - m) / kTemperature * importance_[i];
    }
    mu_.Step(d_mu_);
    return sum * share;
  }

  void Gather(const Reordering& order) override {
    if (!learning_) return;
    mu_.Gather(order);
    std::vector<float> gathered;
    for (const uint32_t i : order.source) gathered.push_back(importance_[i]);
    importance_ = std::move(gathered);
  }

  size_t Held() const override {
    return mu_.Held() + HeldBy(importance_, mask_, d_mu_, opacity_logit_);
  }

 private:
  float weight_;
  int begin_, end_;  // steps that learn
  bool learning_ = false;
  std::vector<float> importance_, mask_, d_mu_;  // [N]
  LearnedMask mu_{0, kFirst, kRate};
  Buffer<float> opacity_logit_;
};

}  // namespace

std::unique_ptr<Pruner> MakeLpPruner(const PruneSettings& settings, int iterations) {
  return std::make_unique<LpPruner>(settings, iterations);
}

}  // namespace cosplat
