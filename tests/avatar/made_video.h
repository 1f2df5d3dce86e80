// A tiny tracked video of the procedural head in memory, and what short trainings on it are told:
// all of it without a file, for the lean build too.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "assets/head/motion.h"
#include "assets/head/video.h"
#include "avatar/play/player.h"
#include "avatar/train/avatar_subject.h"
#include "flame/pose.h"
#include "splat/train/loss/loss.h"

namespace cosplat::test {

inline const ProceduralHead& MadeHead() {
  static const ProceduralHead head = MakeProceduralHeadParts();
  return head;
}

// Means of `by` x `by` pixels, of colours by their alpha.
inline Image8 Shrunk(const Image8& rgba, int by) {
  Image8 small(rgba.width / by, rgba.height / by, 4);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      double sum[3] = {}, alpha = 0;
      for (int k = 0; k < by * by; ++k) {
        const int from_x = by * x + k % by, from_y = by * y + k / by;
        const double a = rgba.at(from_x, from_y, 3);
        for (int c = 0; c < 3; ++c) sum[c] += a * rgba.at(from_x, from_y, c);
        alpha += a;
      }
      for (int c = 0; c < 3; ++c)
        small.at(x, y, c) = uint8_t(std::lround(alpha > 0 ? sum[c] / alpha : 0));
      small.at(x, y, 3) = uint8_t(std::lround(alpha / (by * by)));
    }
  return small;
}

// The first `frames` frames of 96 / resolution pixels a side; of WriteProceduralVideo's script.
inline TrackedVideo MakeSmallVideo(size_t frames, int resolution) {
  constexpr int kSide = 96;
  const auto script = procedural::MakeScript({24, 4, kSide, 0});
  const FlamePoser<float> poser(MadeHead().model, {});
  TrackedVideo video;
  video.source = "made";
  video.shape.assign(size_t(MadeHead().model.shape_count), 0.0f);
  std::vector<float> vertices;
  for (size_t f = 0; f < std::min(frames, script.size()); ++f) {
    poser.Forward(FlamePoser<float>::ParametersOf(script[f].params), vertices);
    const Image8 large =
        RenderProceduralHead(MadeHead(), vertices, script[f].params, script[f].camera);
    TrackedFrame frame;
    frame.name = std::to_string(f);
    frame.timestep = int(f);
    frame.camera = script[f].camera.Resized(kSide / resolution, kSide / resolution);
    frame.params = script[f].params;
    frame.image = std::make_shared<const Image8>(Shrunk(large, resolution));
    video.train.push_back(std::move(frame));
  }
  return video;
}

// Of the made head at rest.
inline TrackedVideo VideoOf(std::vector<TrainFrame> frames) {
  TrackedVideo video;
  video.source = "made";
  video.shape.assign(size_t(MadeHead().model.shape_count), 0.0f);
  for (TrainFrame& made : frames) {
    TrackedFrame frame;
    frame.timestep = int(video.train.size());
    frame.name = std::to_string(frame.timestep);
    frame.camera = made.camera;
    frame.image = std::make_shared<const Image8>(std::move(made.target));
    video.train.push_back(std::move(frame));
  }
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
  avatar.virtual_views = 0;  // what frames show, alone
  return avatar;
}

// Frame's image over white, planar [3, height, width].
inline Buffer<float> Target(const Image8& image) {
  Buffer<float> planar;
  CompositeTarget(image, {1, 1, 1}, planar);
  return planar;
}

// Mean PSNR over white of an avatar on frames of a video.
inline double MeanPsnr(const AvatarModel& avatar,
                       const TrackedVideo& video,
                       const std::vector<TrackedFrame>& frames,
                       const FlameModel& flame = MadeHead().model) {
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
