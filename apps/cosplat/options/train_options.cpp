#include "apps/cosplat/options/train_options.h"

#include <algorithm>
#include <limits>

#include "splat/base/error.h"

namespace cosplat {
namespace {

// Differences from 3DGS in the training of scenes, apart from steps proportional to the run's
// length; docs/reference.md lists the gain of each. Avatars have some of them (AvatarOptions):
// shared opacity degrades their mouths.
void ImproveOn3dgs(TrainSettings& s) {
  s.rates.scale = 1e-2f;
  s.density.shares_opacity = true;
  // What is large beside the distance between the cameras is the background, not a fault.
  s.density.max_scale = std::numeric_limits<float>::infinity();
  s.schedule.opacity_reset_share = 0.25f;
  s.schedule.num_downscales = 2;
  s.schedule.last_rate_share = 0.2f;
  // With its filters fewer Gaussians would be added (docs/scenes.md).
  if (s.antialiasing) s.density.gradient_threshold = 1.6e-4f;
}

}  // namespace

TrainSettings TrainOptions::ToSettings(float extent) const {
  TrainSettings s;
  s.iterations = iterations;
  s.batch = batch;
  s.degree = sh_degree;
  s.seed = seed;
  s.antialiasing = antialiasing;
  s.exposure = exposure;
  s.loss = {1 - lambda_dssim, lambda_dssim, 0};
  if (lambda_lpips > 0 && lpips.empty())
    throw Error("--lambda_lpips", "needs a network: --lpips DIR (docs/lpips.md)");
  s.crop_loss.weight = lambda_lpips;
  s.crop_loss.side = lpips_crop;
  s.rates = rates;
  s.schedule = preset == "3dgs" ? Schedule() : Schedule::Fractions(iterations);
  if (position_lr_final > 0)
    s.rates.position_lr_final = position_lr_final;
  else if (preset != "3dgs")
    s.rates.position_lr_final = Schedule::LastPositionRate(rates.position_lr_init, iterations);
  s.density.split_scale = 0.01f * extent;  // 3DGS: percent_dense
  s.density.max_scale = 0.1f * extent;     // 3DGS
  s.density.max_count = max_gaussians;
  if (preset == "default") ImproveOn3dgs(s);
  if (scaling_lr > 0) s.rates.scale = scaling_lr;
  if (densify_grad_threshold > 0) s.density.gradient_threshold = densify_grad_threshold;
  const auto override_with = [](int value, int& steps) {
    if (value >= 0) steps = value;
  };
  override_with(densify_from, s.schedule.densify_from);
  override_with(densify_until, s.schedule.densify_until);
  override_with(densify_every, s.schedule.densify_every);
  override_with(opacity_reset_every, s.schedule.opacity_reset_every);
  if (opacity_reset_every >= 0) s.schedule.opacity_reset_share = 1;
  override_with(num_downscales, s.schedule.num_downscales);
  override_with(resolution_schedule, s.schedule.downscale_every);
  if (budget == "auto" && prune_to > 0)
    throw Error("--prune-to " + std::to_string(prune_to), "--budget auto finds the count");
  if (budget == "auto" && prune != "none" && prune != "leave-one-out")
    throw Error("--prune " + prune, "--budget auto prunes by leave-one-out");
  if (budget == "auto" && batch > 1)
    throw Error("--batch " + std::to_string(batch), "--budget auto needs steps of one view");
  const bool counts = prune_to > 0 || budget == "auto";
  s.prune.rule = PruneRuleFromString(prune == "none" && counts ? "leave-one-out" : prune);
  s.prune.target = prune_to;
  s.prune.mask_weight = prune_lambda;
  s.drop_bands = drop_bands / 255;
  if (background == "white") s.background = Background::kWhite;
  if (background == "random") s.background = Background::kRandom;
  s.schedule.reset_opacity_at_start = preset == "3dgs" && background == "white";
  return s;
}

Device TrainOptions::ResolveDevice() const {
  const bool processor_only = WorksOnProcessorOnly(PruneRuleFromString(prune));
  return DeviceFromString(device == "auto" && processor_only ? "cpu" : device);
}

void TrainOptions::ResolveBackground(const std::string& automatic) {
  if (white_background) background = "white";
  if (background == "auto") background = automatic;
}

std::array<float, 3> TrainOptions::EvaluationBackground() const {
  const float c = background == "black" ? 0.0f : 1.0f;
  return {c, c, c};
}

bool TrainOptions::ReachesMilestone(const std::vector<int>& milestones,
                                    int before,
                                    int iteration) const {
  return iteration == iterations ||
         std::any_of(milestones.begin(), milestones.end(), [&](int milestone) {
           return before < milestone && milestone <= iteration;
         });
}

}  // namespace cosplat
