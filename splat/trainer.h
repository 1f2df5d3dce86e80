// The training loop: one for static scenes and avatars alike.
//
// frame -> Subject::Place -> Rasterizer -> loss -> back -> Subject::PlaceBackward -> Adam, and
// every so often density control. What a frame is, where the Gaussians are in it and what comes of
// their gradients is the Subject's business: SceneSubject below, avatar/trainer.h for avatars.
#pragma once

#include <any>
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "splat/bands.h"
#include "splat/density.h"
#include "splat/loss.h"
#include "splat/optimizer.h"
#include "splat/prune/pruner.h"
#include "splat/rasterizer.h"
#include "splat/schedule.h"
#include "splat/subject.h"

namespace cosplat {

// Which Gaussians a step's Adam works on: every one, as in 3DGS, or groups of which one has a
// gradient, while what momentum does to the others is put off until they have one again
// (splat/optimizer.h, docs/performance.md).
enum class AdamOn { kAll, kDrawn };

enum class Background { kBlack, kWhite, kRandom };

// Rates of 3DGS (Kerbl et al. 2023, released code) unless said otherwise.
struct LearningRates {
  float position_first = 1.6e-4f;  // times the subject's extent
  float position_last = 1.6e-6f;
  float color = 2.5e-3f;
  float rest = 0;  // of the coefficients of bands 1..; 0: color / 20 (3DGS)
  float opacity = 0.05f;
  float scale = 5e-3f;
  float rotation = 1e-3f;

  float RestRate() const { return rest > 0 ? rest : color / 20; }
};

// Keeps needles and giants in check: mean of the largest standard deviation over those Gaussians
// that are both larger than `limit` and more than `ratio` times longer than wide (SplattingAvatar).
struct ScaleRegularizer {
  float weight = 0;
  float limit = 0.008f;  // scene units
  float ratio = 10;
};

struct TrainSettings {
  int iterations = 30000;
  int degree = 3;        // highest band trained
  int first_degree = 0;  // bands active from step 0; one more per Schedule::degree_every
  uint64_t seed = 0;
  Background background = Background::kBlack;
  LossWeights loss;
  ScaleRegularizer scale_regularizer;
  LearningRates rates;
  std::array<float, kAttributeCount> eps{1e-15f, 1e-15f, 1e-15f, 1e-15f, 1e-15f, 1e-15f};
  Schedule schedule;
  DensitySettings density;
  PruneSettings prune;
  float drop_bands = 0;  // threshold of DropBandsInTraining (splat/bands.h); 0: all stay
  AdamOn adam_on = AdamOn::kDrawn;
  int exp_degree = kMaxExpDegree;  // of the blend loop's exponential (splat/config.h)
};

// Everything that a run is at a moment, beside its subject's own state (AvatarTrainingState) and
// what a rule of pruning learns: writing and reading it makes an exact checkpoint. Until the last
// iteration, `adam` may have put off something for Gaussians that were not drawn lately.
struct TrainingState {
  Gaussians gaussians;
  AdamState adam;
  DensityStatistics statistics;
  Rng rng;
  int iteration = 0;
  std::vector<uint32_t> frames_left;  // of the current pass, in the order they will be popped
};

struct StepReport {
  int iteration = 0;
  double loss = 0;
  size_t gaussians = 0;
};

// What a run cost: stats.json.
struct TrainingStatistics {
  int iterations = 0;
  size_t steps = 0;        // more than iterations where the run went back, as for a budget
  double seconds = 0;      // in the training loop: no loading, no evaluation
  double cpu_seconds = 0;  // processor time of all threads, likewise
  size_t gaussians = 0;
  double ms_per_step = 0;  // median of the last 200 steps
  PhaseTimes times;
  size_t ignored_gradients = 0;  // non-finite ones
  DegreeCounts degrees{};
  DegreeFigures bands;
  double drop_psnr = 0;  // dB, changes of training PSNR by dropping bands, all rounds together
};

class Trainer {
 public:
  Trainer(const TrainSettings& settings, Subject& subject, Gaussians first);

  // One iteration. Throws Error when the loss is not finite, the frame's image is not of its
  // camera's size or every Gaussian was pruned.
  StepReport Step();

  const TrainingState& state() const { return state_; }
  // Takes these frames out of what is trained on (an empty list gives all back), and begins a new
  // pass: evidence for choices made during the run (splat/budget.h).
  void HoldOut(std::vector<uint32_t> frames);
  // Mean PSNR of these frames as they stand, over the background of training (mid-grey where that
  // is random), pictures clamped to what bytes can show.
  double PsnrOf(View<const uint32_t> frames);
  // The first step that the rule of pruning has a round after; 0 when there is none.
  int FirstPruneStep() const;
  // A point to go back to, and back. The rule of pruning starts anew with another target: it must
  // be one that keeps nothing between rounds. Times go on: what was tried was paid for.
  struct Checkpoint {
    TrainingState state;
    std::any subject;
    size_t ignored_gradients;
    double drop_psnr;
  };
  Checkpoint Save() const { return {state_, subject_.SaveState(), ignored_gradients_, drop_psnr_}; }
  void Restore(const Checkpoint& checkpoint, const PruneSettings& prune);
  // The Gaussians with all that Adam has put off: what to save or judge in the middle of a run. A
  // copy, since making up for it in place would change the run's bits.
  Gaussians CaughtUp() const;
  const TrainSettings& settings() const { return settings_; }
  int active_degree() const;
  size_t frame_count() const { return subject_.frame_count(); }
  TrainingStatistics statistics() const;
  // Everything held between two steps, except what the subject holds.
  std::vector<MemoryPart> Memory() const;

 private:
  size_t NextFrame();
  std::array<float, 3> NextBackground();
  AdamSettings RatesAt(int iteration) const;
  // The step's parts: draw and compare, gradients, parameters.
  double Forward(size_t index);
  double Backward(int iteration);  // returns what the rule of pruning adds to the loss
  void Update(int iteration);
  double RegularizeScale();
  void FindGroups();
  void ReleaseScratch();
  void ControlDensityAt(int iteration);
  PruneRound Rank(int iteration);
  bool DropsBandsAt(int iteration) const;
  std::array<float, 3> MeanBackground() const;
  bool PrunesAt(int iteration) const { return pruner_ && pruner_->PrunesAt(iteration); }
  // What moves along when Gaussians come and go.
  Population Everyone();

  TrainSettings settings_;
  Subject& subject_;
  TrainingState state_;
  std::unique_ptr<Pruner> pruner_;  // null: no rule
  std::vector<uint32_t> frames_;    // that are trained on
  // Scratch, kept between steps.
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  WorldGaussians world_;  // this step's
  RenderedImage image_;
  PhotometricLoss loss_;
  Buffer<float> d_color_, screen_;
  Gaussians gradients_;
  std::vector<uint32_t> needles_;  // that this step regularises, ascending
  std::vector<uint32_t> groups_;   // that its Adam works on
  // Measurements.
  PhaseTimes times_;
  double seconds_ = 0, cpu_seconds_ = 0;
  std::array<double, 200> last_seconds_{};  // of steps, written in turn
  size_t steps_ = 0;
  size_t ignored_gradients_ = 0;
  double drop_psnr_ = 0;
};

}  // namespace cosplat
