// The behaviour of DCSHARP's released code, for comparison: the score is |dL/ds| of the first axis
// only, the 2 % with the highest scores are removed, and they are marked before cloning and
// splitting but removed by index afterwards, so that other Gaussians than intended are removed.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "apps/study/rules/rules.h"
#include "splat/device/buffer.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

class DcsharpReleasedPruner : public Pruner {
 public:
  DcsharpReleasedPruner(const Schedule& schedule, size_t gaussians)
      : schedule_(schedule), sum_(gaussians, 0.0f), seen_(gaussians, 0.0f) {}

  bool PrunesAt(int iteration) const override { return schedule_.DensifiesAt(iteration); }

  void AfterBackward(const Gaussians& gaussians,
                     const Gaussians& gradients,
                     View<const float> radii) override {
    for (size_t i = 0; i < sum_.size(); ++i) {
      if (!(radii[i] > 0)) continue;
      const float d = gradients.at(kScaleLog, i)[0] / std::exp(gaussians.at(kScaleLog, i)[0]);
      if (!std::isfinite(d)) continue;
      sum_[i] += std::abs(d);
      seen_[i] += 1;
    }
  }

  void BeforeDensification() override {
    std::vector<float> mean(sum_.size());
    for (size_t i = 0; i < mean.size(); ++i) mean[i] = seen_[i] > 0 ? sum_[i] / seen_[i] : 0.0f;
    std::vector<uint32_t> by_score(mean.size());
    std::iota(by_score.begin(), by_score.end(), 0u);
    std::stable_sort(by_score.begin(), by_score.end(), [&](uint32_t a, uint32_t b) {
      return mean[a] > mean[b];
    });
    marked_.assign(mean.size(), 0);
    by_score.resize(ShareOf(DensificationRounds::kShare, mean.size()));
    for (const uint32_t i : by_score) marked_[i] = 1;
    marked_before_splitting_ = true;
  }

  void Gather(const Reordering& order) override {
    const size_t n = order.source.size();
    sum_.assign(n, 0.0f);  // the accumulators restart
    seen_.assign(n, 0.0f);
    if (marked_before_splitting_) {
      marked_before_splitting_ = false;
      marked_.resize(n, 0);  // the error: marks stay at their old indices
      return;
    }
    std::vector<uint8_t> gathered(n, 0);
    for (size_t i = 0; i < n && !marked_.empty(); ++i) gathered[i] = marked_[order.source[i]];
    marked_ = std::move(gathered);
  }

  PruneRound Rank(const PruneContext& context) override {
    PruneRound round;
    round.score.assign(context.gaussians.size(), 1.0f);
    for (size_t i = 0; i < round.score.size(); ++i) {
      if (!marked_[i]) continue;
      round.score[i] = 0;
      ++round.remove;
    }
    return round;
  }

  size_t allocated_bytes() const override { return AllocatedBytes(sum_, seen_, marked_); }
  // Between steps no marks are pending: densification and the round after it are one step.
  void Serialize(StateArchive& archive, size_t count) override {
    archive.Array("dcsharp_released.sum", sum_, count);
    archive.Array("dcsharp_released.seen", seen_, count);
  }

 private:
  Schedule schedule_;
  std::vector<float> sum_, seen_;  // of |dL/ds_x|; number of steps where visible
  std::vector<uint8_t> marked_;
  bool marked_before_splitting_ = false;
};

}  // namespace

std::unique_ptr<Pruner> MakeDcsharpReleasedPruner(const PruneSettings&, const PrunedRun& run) {
  return std::make_unique<DcsharpReleasedPruner>(run.schedule, run.gaussians);
}

}  // namespace cosplat
