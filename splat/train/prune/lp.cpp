// LP-3DGS: from step 19,500 to 20,000 of 30,000, a learned soft mask scales each opacity
// (splat/train/prune/kernels/prune_mask.h), where S is LightGaussian's score normalised to a
// maximum of
// 1. Then the Gaussians that the mask rather hides than shows (mu S < 0) are removed, once.
#include <algorithm>

#include "splat/train/prune/kernels/prune_mask.h"
#include "splat/train/prune/learned_mask.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

constexpr float kLpFirst = 1, kLpRate = 0.05f;
constexpr float kLpMaskWeight = 5e-4f;

class LpPruner : public Pruner {
 public:
  LpPruner(const PruneSettings& settings, int iterations)
      : weight_(settings.mask_weight > 0 ? settings.mask_weight : kLpMaskWeight),
        begin_(std::max(1, int(int64_t(iterations) * 19500 / 30000))),
        end_(std::max(begin_ + 1, int(int64_t(iterations) * 20000 / 30000))) {}

  bool PrunesAt(int iteration) const override { return iteration == begin_ || iteration == end_; }

  // The first round computes the scores and starts learning; the second removes.
  PruneRound Rank(const PruneContext& context) override {
    const size_t n = context.gaussians.size();
    PruneRound round{std::vector<float>(n, 1.0f), {}, 0};
    if (!learning_) {
      importance_ = Significance(context.gaussians, ContributionsIn(context));
      const float max = *std::max_element(importance_.begin(), importance_.end());
      for (float& s : importance_) s /= std::max(max, 1e-30f);
      mu_ = LearnedMask(n, kLpFirst, kLpRate);
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

  MaskInSteps Mask() override {
    if (!learning_) return {};
    return {MaskKind::kSoft, weight_, &mu_, &importance_};
  }

  size_t allocated_bytes() const override {
    return mu_.allocated_bytes() + AllocatedBytes(importance_);
  }
  void Serialize(StateArchive& archive, size_t count) override {
    uint8_t learning = learning_;
    archive.Value("lp.learning", learning);
    learning_ = learning != 0;
    if (!learning_) return;
    archive.Array("lp.importance", importance_, count);
    mu_.Serialize(archive, "lp.mu", count);
  }

 private:
  float weight_;
  int begin_, end_;  // steps between which the mask is learned
  bool learning_ = false;
  std::vector<float> importance_;  // [N]
  LearnedMask mu_{0, kLpFirst, kLpRate};
};

}  // namespace

std::unique_ptr<Pruner> MakeLpPruner(const PruneSettings& settings, const PrunedRun& run) {
  return std::make_unique<LpPruner>(settings, run.iterations);
}

}  // namespace cosplat
