// A small synthetic scene with known Gaussians, and runs of training on its images.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "splat/eval/metrics.h"
#include "splat/media/image_io.h"
#include "splat/train/start/initialize.h"
#include "splat/train/trainer.h"
#include "tests/support/looking_at.h"
#include "tests/support/same_bits.h"

namespace cosplat::test {

// Opaque blobs of different colours in a ball of radius ~0.6; colours change with the direction
// when `degree` is 1 or more.
inline Gaussians TrueScene(int degree, size_t count = 40) {
  Rng rng{17};
  Gaussians g;
  g.degree = degree;
  g.Resize(count);
  for (size_t i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) {
      g.at(kPosition, i)[k] = std::clamp(0.3f * rng.Normal(), -0.6f, 0.6f);
      g.at(kScaleLog, i)[k] = std::log(0.12f) + 0.3f * rng.Normal();
      g.at(kColorDc, i)[k] = 3.4f * (rng.Uniform() - 0.5f);
    }
    for (int k = 0; k < 4; ++k) g.at(kRotation, i)[k] = rng.Normal();
    g.at(kOpacityLogit, i)[0] = 2;
    for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = 0.08f * rng.Normal();
  }
  return g;
}

inline RenderedImage Render(const Gaussians& g,
                            const Camera& camera,
                            const std::array<float, 3>& background = {0, 0, 0}) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(ViewOf(g), g.basis, camera, {background, g.degree}, image, *tape);
  return image;
}

// The true scene's images: RGB on black, or RGBA with straight alpha.
inline std::vector<TrainFrame> TargetImages(const Gaussians& truth,
                                            const std::vector<Camera>& cameras,
                                            bool with_alpha = false) {
  std::vector<TrainFrame> frames;
  for (const Camera& camera : cameras) {
    const RenderedImage image = Render(truth, camera);
    frames.push_back({camera, ToBytes(with_alpha ? image.ToStraightAlpha() : image.ToImage())});
  }
  return frames;
}

// First Gaussians: `count` grey points in the cube that holds the scene.
inline Gaussians FirstGaussians(size_t count, int degree, Basis basis = Basis::kDcsh) {
  Rng rng{5};
  std::vector<float> points(3 * count);
  for (float& p : points) p = 1.4f * (rng.Uniform() - 0.5f);
  return InitializeFromPoints(points, std::vector<uint8_t>(3 * count, 128), degree, basis);
}

// Fractions of 30,000 iterations as in a real run, but with rates and an interval of densification
// for a run of hundreds of steps.
inline TrainSettings ShortRun(int iterations, int degree) {
  TrainSettings s;
  s.iterations = iterations;
  s.degree = degree;
  s.seed = 3;
  s.schedule = Schedule::Fractions(iterations);
  s.schedule.densify_every = 20;
  s.rates.position_lr_init = 3e-3f;
  s.rates.position_lr_final = 1e-4f;
  s.rates.color = 2e-2f;
  s.rates.scale = 2e-2f;
  s.rates.rotation = 1e-2f;
  s.density.split_scale = 0.05f;
  s.density.max_scale = 1;
  s.density.max_count = 600;
  return s;
}

// Of Gaussians that nobody trains.
struct ImagesOf : FrameImages {
  ImagesOf(Subject& subject, const Gaussians& gaussians) : subject(subject), gaussians(gaussians) {}
  std::vector<Contribution> Contributions(const FrameChoice& choice) override {
    std::vector<Contribution> sums(gaussians.size());
    RenderedImage image;
    Buffer<Contribution> more;
    for (size_t k = 0; k < choice.count(); ++k) {
      rasterizer->Forward(subject.ToWorld(gaussians, choice[k]),
                          gaussians.basis,
                          WithMargin(subject.frame(choice[k]).camera, choice.margin),
                          {choice.background, choice.degree},
                          image,
                          *tape);
      rasterizer->Contributions(image, *tape, more);
      for (size_t i = 0; i < sums.size(); ++i) sums[i] += more[i];
    }
    return sums;
  }
  ImageError ErrorIn(const FrameChoice& choice) override {
    return ErrorOfFrames(subject, gaussians, choice, false, *rasterizer, *tape);
  }
  ImageError ErrorWithout(View<const uint8_t> removed, const FrameChoice& choice) override {
    Gaussians rest = gaussians;
    Hide(removed, rest);
    return ErrorOfFrames(subject, rest, choice, false, *rasterizer, *tape);
  }
  Subject& subject;
  const Gaussians& gaussians;
  std::unique_ptr<Rasterizer> rasterizer = MakeCpuRasterizer();
  std::unique_ptr<RenderTape> tape = rasterizer->MakeTape();
};

inline TrainingState Train(const TrainSettings& settings,
                           Subject& subject,
                           const Gaussians& first,
                           int steps) {
  Trainer trainer(settings, subject, first);
  for (int i = 0; i < steps; ++i) trainer.Step();
  return trainer.state();
}

// Mean over the frames; targets on black.
inline double MeanPsnr(const Gaussians& g, const std::vector<TrainFrame>& frames) {
  double sum = 0;
  for (const TrainFrame& frame : frames)
    sum += CompareImages(ToBytes(Render(g, frame.camera).ToImage()), frame.target).psnr;
  return sum / double(frames.size());
}

inline bool SameBits(const Gaussians& a, const Gaussians& b) {
  for (int i = 0; i < kAttributeCount; ++i)
    if (!SameBits(a.values[i], b.values[i])) return false;
  return true;
}
inline bool SameBits(const TrainingState& a, const TrainingState& b) {
  return SameBits(a.gaussians, b.gaussians) && SameBits(a.adam.m, b.adam.m) &&
         SameBits(a.adam.v, b.adam.v) && a.adam.step == b.adam.step &&
         SameBits(a.statistics.plasticity, b.statistics.plasticity) &&
         SameBits(a.statistics.screen_gradient, b.statistics.screen_gradient) &&
         SameBits(a.exposures.value, b.exposures.value) && SameBits(a.exposures.v, b.exposures.v) &&
         a.rng.state == b.rng.state && a.iteration == b.iteration && a.frames_left == b.frames_left;
}

}  // namespace cosplat::test
