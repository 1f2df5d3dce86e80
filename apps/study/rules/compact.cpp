// Compact-3DGS's hard mask (splat/train/prune/kernels/prune_mask.h). Gaussians that it hides are
// removed at each densification and, afterwards, every 1,000 of 30,000 steps and at the end.
#include "apps/study/rules/rules.h"
#include "splat/train/prune/kernels/prune_mask.h"
#include "splat/train/prune/learned_mask.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

constexpr float kFirst = 1, kRate = 0.01f;
constexpr float kMaskWeight = 5e-4f;  // for captured scenes; 4e-3 for synthetic ones

class CompactPruner : public Pruner {
 public:
  CompactPruner(const PruneSettings& settings, const PrunedRun& run)
      : weight_(settings.mask_weight > 0 ? settings.mask_weight : kMaskWeight),
        schedule_(run.schedule),
        iterations_(run.iterations),
        late_(PruneRounds::Scaled(run.iterations, 15000, 1000, 30000)),
        mask_(run.gaussians, kFirst, kRate) {}

  bool PrunesAt(int iteration) const override {
    return schedule_.DensifiesAt(iteration) || late_.At(iteration) || iteration == iterations_;
  }

  MaskInSteps Mask() override { return {MaskKind::kHard, weight_, &mask_, nullptr}; }
  size_t allocated_bytes() const override { return mask_.allocated_bytes(); }
  void Serialize(StateArchive& archive, size_t count) override {
    mask_.Serialize(archive, "compact", count);
  }

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
};

}  // namespace

std::unique_ptr<Pruner> MakeCompactPruner(const PruneSettings& settings, const PrunedRun& run) {
  return std::make_unique<CompactPruner>(settings, run);
}

}  // namespace cosplat
