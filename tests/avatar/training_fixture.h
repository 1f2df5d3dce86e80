// A tiny tracked video of the procedural head, and short trainings on it.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "avatar/player.h"
#include "avatar/trainer.h"
#include "flame/procedural/video.h"
#include "flame/procedural_head.h"
#include "splat/loss.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {

// 24 frames of 96 x 96, the last 4 held out; made once per process.
struct SmallVideo {
  TemporaryFolder folder;
  FlameModel flame = MakeProceduralHead();
  SmallVideo() {
    MakeHeadOptions options;
    options.frames = 24;
    options.test_frames = 4;
    options.size = 96;
    WriteProceduralVideo(folder.path(), options);
  }
  static const SmallVideo& Get() {
    static const SmallVideo video;
    return video;
  }
};

// The first `frames` training frames at 96 / resolution pixels.
inline TrackedVideo LoadSmallVideo(size_t frames, int resolution) {
  TrackedVideo video = LoadTrackedVideo(SmallVideo::Get().folder.path(), {-1, resolution});
  if (video.train.size() > frames) video.train.resize(frames);
  return video;
}

// 3DGS's schedule in proportion, without resets of opacity, and no more than `max_count`.
inline TrainSettings ShortRun(int iterations, size_t max_count) {
  TrainSettings s;
  s.iterations = iterations;
  s.background = Background::kRandom;
  s.scale_regularizer.weight = 1;
  s.schedule.densify_from = iterations / 10;
  s.schedule.densify_until = iterations / 2;
  s.schedule.densify_every = std::max(1, iterations / 10);
  s.schedule.opacity_reset_every = iterations + 1;
  s.schedule.degree_every = std::max(1, iterations / 10);
  s.schedule.size_prune_after = iterations;
  s.schedule.position_rate_steps = iterations;
  s.density.max_count = max_count;
  s.prune.group_cap = 64;
  return s;
}

inline AvatarSettings SmallAvatar(size_t gaussians) {
  AvatarSettings avatar;
  avatar.initial_gaussians = gaussians;
  avatar.bust = AvatarSettings::BustChoice::kNo;
  return avatar;
}

// A subject and its trainer. S: AvatarSubject or derived from it.
template <class S = AvatarSubject>
struct Training {
  S subject;
  TrainSettings settings;
  Trainer trainer;

  Training(TrackedVideo video,
           const AvatarSettings& avatar,
           const TrainSettings& first_settings,
           const FlameModel& flame = SmallVideo::Get().flame)
      : subject(flame, std::move(video), avatar),
        settings(Scaled(first_settings, subject.extent())),
        trainer(settings,
                subject,
                subject.InitialGaussians(settings.degree, Basis::kDcsh, settings.seed)) {}

  // Mean loss of the last tenth.
  double Run(int steps) {
    double sum = 0;
    const int last = std::max(1, steps / 10);
    for (int i = 0; i < steps; ++i) {
      const double loss = trainer.Step().loss;
      if (i >= steps - last) sum += loss / last;
    }
    return sum;
  }
  const Gaussians& gaussians() const { return trainer.state().gaussians; }
  AvatarModel Model() const { return subject.Model(gaussians()); }

 private:
  static TrainSettings Scaled(TrainSettings settings, float unit) {
    ScaleToUnit(unit, settings);
    return settings;
  }
};

// Frame's picture over white, planar [3, height, width].
inline Buffer<float> Target(const Image8& image) {
  Buffer<float> planar;
  CompositeTarget(image, {1, 1, 1}, planar);
  return planar;
}

// Mean PSNR over white of an avatar on frames of a video.
inline double MeanPsnr(const AvatarModel& avatar,
                       const TrackedVideo& video,
                       const std::vector<TrackedFrame>& frames,
                       const FlameModel& flame = SmallVideo::Get().flame) {
  Player player(avatar, flame);
  RenderedImage image;
  double sum = 0;
  for (const TrackedFrame& frame : frames) {
    player.RenderOver(frame.params, frame.camera, {1, 1, 1}, image);
    const Buffer<float> target = Target(LoadTrackedImage(video, frame));
    sum += Psnr(image.color, target);
  }
  return sum / double(frames.size());
}

}  // namespace cosplat::test
