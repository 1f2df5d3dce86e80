#include "apps/cosplat/options/train_options.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr int kRuleSteps = 30000;  // that PresetRules::densify_from and densify_until are of

}  // namespace

TrainSettings TrainOptions::SettingsBy(const PresetRules& rules, float extent) const {
  TrainSettings s;
  s.iterations = iterations;
  s.batch = batch;
  s.degree = sh_degree;
  s.first_degree = rules.all_bands_at_start ? sh_degree : 0;
  s.seed = seed;
  s.antialiasing = antialiasing;
  s.exposure = exposure;
  s.loss = {1 - lambda_dssim, lambda_dssim, rules.mse};
  if (renderings) s.late_mse = Schedule::LateMse(rules.renderings_late_mse, iterations);
  if (lambda_lpips > 0 && lpips.empty())
    throw Error("--lambda_lpips", "needs a network: --lpips DIR (docs/lpips.md)");
  s.color_curvature = rules.color_curvature;
  s.crop_loss.weight = lambda_lpips;
  s.crop_loss.side = lpips_crop;
  s.rates = rules.rates;
  s.rates.position_lr_init = position_lr_init;
  if (rules.color_rate_by_length) s.rates.color = Schedule::ColorRate(s.rates.color, iterations);
  s.rates.color = feature_lr.value_or(s.rates.color);
  s.rates.rest = rest_lr;
  s.rates.opacity = opacity_lr.value_or(s.rates.opacity);
  s.rates.scale = scaling_lr.value_or(s.rates.scale);
  s.rates.rotation = rotation_lr.value_or(s.rates.rotation);
  s.schedule = ScheduleBy(rules);
  if (position_lr_final)
    s.rates.position_lr_final = *position_lr_final;
  else if (rules.in_proportion)
    s.rates.position_lr_final = Schedule::LastPositionRate(position_lr_init, iterations);
  s.density.split_scale = 0.01f * extent;                   // 3DGS: percent_dense
  s.density.max_scale = rules.limits_scale ? 0.1f * extent  // 3DGS
                                           : std::numeric_limits<float>::infinity();
  s.density.max_count = max_gaussians;
  s.density.shares_opacity = rules.shares_opacity;
  s.density.cuts_long_axis = iterations <= rules.long_axis_max_steps && !antialiasing;
  float& threshold = s.density.gradient_threshold;
  if (antialiasing) threshold = rules.antialiased_grad_threshold.value_or(threshold);
  if (renderings && s.density.cuts_long_axis)
    threshold = rules.long_axis_renderings_grad_threshold;
  else if (renderings)
    threshold = std::min(threshold, rules.renderings_grad_threshold.value_or(threshold));
  threshold = densify_grad_threshold.value_or(threshold);
  if (finds_budget && prune_to)
    throw Error("--prune-to " + std::to_string(*prune_to), "--budget auto finds the count");
  if (finds_budget && prune != "none" && prune != "leave-one-out")
    throw Error("--prune " + prune, "--budget auto prunes by leave-one-out");
  const bool counts = prune_to || finds_budget;
  s.prune.rule = prune == "none" && counts ? "leave-one-out" : prune;
  s.prune.target = prune_to.value_or(0);
  if (tolerance != TrainOptions().tolerance && (prune_to || s.prune.rule != "leave-one-out"))
    throw Error("--tolerance", "is of --budget auto");
  s.prune.tolerance = tolerance;
  s.prune.mask_weight = prune_lambda.value_or(0);
  s.drop_bands = drop_bands / 255;
  s.background = background.value_or(Background::kBlack);
  return s;
}

Schedule TrainOptions::ScheduleBy(const PresetRules& rules) const {
  Schedule s = rules.in_proportion ? Schedule::Fractions(iterations) : Schedule();
  const auto scaled = [&](int steps) {
    return int(std::lround(double(steps) * iterations / kRuleSteps));
  };
  if (rules.densify_from) s.densify_from = scaled(*rules.densify_from);
  if (rules.densify_until) s.densify_until = scaled(*rules.densify_until);
  s.opacity_reset_share = opacity_reset_every ? 1 : rules.opacity_reset_share;
  s.last_rate_share = rules.last_rate_share;
  s.densify_from = densify_from.value_or(s.densify_from);
  s.densify_until = densify_until.value_or(s.densify_until);
  if (densify_from && s.densify_until > 0 && densify_until && s.densify_from > s.densify_until)
    throw Error("--densify_from_iter " + std::to_string(s.densify_from),
                "is after --densify_until_iter " + std::to_string(s.densify_until));
  s.densify_every = densify_every.value_or(s.densify_every);
  s.opacity_reset_every = opacity_reset_every.value_or(s.opacity_reset_every);
  s.num_downscales = num_downscales.value_or(rules.num_downscales);
  s.downscale_every = resolution_schedule.value_or(s.downscale_every);
  s.reset_opacity_at_start = !rules.in_proportion && background == Background::kWhite;
  return s;
}

Device TrainOptions::ResolveDevice() const {
  return UsableDevice(!device && FindPruneRule(prune).on_host ? Device::kCpu : device);
}

void TrainOptions::ResolveBackground(Background automatic) {
  if (white_background && background.value_or(Background::kWhite) != Background::kWhite)
    throw Error("-w, --background", "are two backgrounds: give one");
  if (white_background) background = Background::kWhite;
  background = background.value_or(automatic);
}

std::array<float, 3> TrainOptions::EvaluationBackground() const {
  const float c = background == Background::kBlack ? 0.0f : 1.0f;
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
