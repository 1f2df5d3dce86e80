// When things happen in a training run: at fractions of its length, so that a short run is a scaled
// version of 3DGS's 30,000 iterations; or at 3DGS's absolute steps (`--preset 3dgs`).
#pragma once

#include <algorithm>
#include <cmath>

namespace cosplat {

struct Schedule {
  static constexpr int kMinDensifyEvery = 200;  // in runs shorter than 3DGS's
  static constexpr int kMinResetEvery = 500;

  int densify_from = 500;
  int densify_until = 15000;
  int densify_every = 100;
  int opacity_reset_every = 3000;
  float opacity_reset_share = 1;  // share of densify_until after which there are none
  int degree_every = 1000;        // steps until one more band is trained
  int size_prune_after = 3000;    // oversized Gaussians are removed from here on
  int position_rate_steps = 30000;
  bool reset_opacity_at_start = false;  // also at densify_from (3DGS on a white background)
  // Image sides are divided by 2^num_downscales at first, and double every downscale_every steps.
  // Not part of 3DGS.
  int num_downscales = 0;
  int downscale_every = 3000;
  // Learning rates other than that of positions decay log-linearly to last_rate_share of their
  // value, from the fraction rates_fall_from of position_rate_steps on. In 3DGS they are constant.
  float last_rate_share = 1;
  float rates_fall_from = 0.8f;

  // 3DGS's steps scaled by iterations / 30,000. Two of them have a minimum: screen gradients
  // averaged over few steps are noise, and recovering from an opacity reset takes a few hundred
  // steps (measured in docs/tried.md).
  static Schedule Fractions(int iterations) {
    const Schedule full;
    const auto scaled = [iterations](int steps) {
      return std::max(1, int(std::lround(double(steps) * iterations / 30000)));
    };
    Schedule s;
    s.densify_from = scaled(full.densify_from);
    s.densify_until = scaled(full.densify_until);
    s.densify_every = scaled(full.densify_every);
    if (iterations < 30000) s.densify_every = std::max(kMinDensifyEvery, s.densify_every);
    s.opacity_reset_every = std::max(kMinResetEvery, scaled(full.opacity_reset_every));
    s.degree_every = scaled(full.degree_every);
    s.size_prune_after = scaled(full.size_prune_after);
    s.position_rate_steps = iterations;
    s.downscale_every = scaled(full.downscale_every);
    return s;
  }

  // That of a part of a scene which `share` of the scene's views show, trained on these alone: a
  // Gaussian of it is seen as often between two events as in a training of the whole scene.
  Schedule OfPart(double share) const {
    Schedule s = *this;
    for (int* steps : {&s.densify_from,
                       &s.densify_until,
                       &s.densify_every,
                       &s.opacity_reset_every,
                       &s.degree_every,
                       &s.size_prune_after,
                       &s.position_rate_steps,
                       &s.downscale_every})
      *steps = std::max(1, int(std::lround(share * *steps)));
    return s;
  }

  bool DensifiesAt(int iteration) const {
    return iteration > densify_from && iteration < densify_until && iteration % densify_every == 0;
  }
  bool ResetsOpacityAt(int iteration) const {
    return iteration < opacity_reset_share * float(densify_until) &&
           (iteration % opacity_reset_every == 0 ||
            (reset_opacity_at_start && iteration == densify_from));
  }
  int DegreeAt(int iteration, int highest) const {
    return std::min(highest, iteration / degree_every);
  }
  // Factor that the sides of an image are divided by in this step; steps count from 1.
  int DownscaleAt(int iteration) const {
    return 1 << std::max(0, num_downscales - (iteration - 1) / downscale_every);
  }
  // Rounds of densification after `iteration`, excluding it.
  int DensificationsAfter(int iteration) const {
    return std::max(0, (densify_until - 1) / densify_every - iteration / densify_every);
  }
  // The final position learning rate of a scaled run. 3DGS's final rate, a hundredth of the first,
  // is meant for 30,000 steps. The distance that a Gaussian can still move is learning rate times
  // steps, so the share grows as a run gets shorter (measured in docs/tried.md).
  static float LastPositionRate(float first, int iterations) {
    return first * std::clamp(300.0f / float(iterations), 0.01f, 1.0f);
  }
  // Colours learn faster the shorter a run is, four times as fast at most. In 30,000 steps the
  // rates of short runs fit what training views alone show (measured in docs/reference.md).
  static float ColorRate(float rate_of_30000, int iterations) {
    return rate_of_30000 * std::clamp(30000.0f / float(iterations), 1.0f, 4.0f);
  }
  // TrainSettings::late_mse. In 30,000 steps that of short runs costs SSIM (docs/reference.md).
  static float LateMse(float of_short_runs, int iterations) {
    return of_short_runs * std::min(15000.0f / float(iterations), 1.0f);
  }
  // Factor on the learning rates other than that of positions.
  float RateShare(int iteration) const {
    const float t =
        (float(iteration) / position_rate_steps - rates_fall_from) / (1 - rates_fall_from);
    return t > 0 ? std::pow(last_rate_share, t) : 1.0f;
  }
  // Log-linear from `first` to `last` (Plenoxels, 3DGS).
  float PositionRate(int iteration, float first, float last) const {
    if (first <= 0 || last <= 0) return std::max(first, 0.0f);  // no logarithm: keeps the first one
    const float t = std::clamp(float(iteration) / position_rate_steps, 0.0f, 1.0f);
    return std::exp((1 - t) * std::log(first) + t * std::log(last));
  }
};

}  // namespace cosplat
