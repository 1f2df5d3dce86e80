// apps/cosplat/options/avatar_options.h and train_options.h: what each preset settles, and that
// what is given counts more.
#include "apps/cosplat/options/avatar_options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "apps/cosplat/options/command_line.h"
#include "apps/cosplat/options/scene_options.h"
#include "splat/base/files.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

// A command line up to the start of training.
struct Parsed {
  CLI::App app;
  CLI::App* command = app.add_subcommand("train-avatar");
  AvatarOptions options;
  std::string config;

  explicit Parsed(std::vector<std::string> arguments) {
    command->fallthrough();
    command->option_defaults()->always_capture_default();
    AddConfig(app);
    options.Declare(*command);
    arguments.insert(arguments.begin(),
                     {"train-avatar", "-s", "video", "-m", "out", "--flame", "head.npz"});
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
    app.parse(arguments);
    options.Settle(*command);
    config = ConfigOf(app, *command);
  }
  bool ConfigHas(const std::string& line) const {
    return ("\n" + config).find("\n" + line + "\n") != std::string::npos;
  }
};

TEST(AvatarPreset, CosplatIsTheDefaultAndOurs) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{}, {"--preset", "cosplat"}}) {
    const Parsed p(arguments);
    EXPECT_EQ(p.options.avatar.system, AvatarSystem::kCosplat);
    EXPECT_EQ(p.options.sh_degree, 2);
    EXPECT_EQ(p.options.basis, Basis::kDcsh);
    EXPECT_EQ(p.options.avatar.color_frame, ColorFrame::kSurface);
    EXPECT_EQ(p.options.avatar.bust, AvatarSettings::BustChoice::kAuto);
    const TrainSettings s = p.options.ToSettings(0.25f);
    EXPECT_EQ(s.iterations, 6000);
    EXPECT_EQ(s.first_degree, 0);
    EXPECT_FLOAT_EQ(s.loss.l1, 0.8f);
    EXPECT_FLOAT_EQ(s.loss.dssim, 0.2f);
    EXPECT_EQ(s.loss.mse, 0);
    EXPECT_FLOAT_EQ(s.rates.position_lr_init, 6.4e-4f);
    EXPECT_FLOAT_EQ(s.rates.position_lr_final, 3.2e-5f);
    EXPECT_EQ(s.schedule.densify_from, 100);
    EXPECT_EQ(s.schedule.densify_until, 3000);
    EXPECT_EQ(s.prune.group_cap, 64);
  }
}

void ExpectSplattingAvatar(const AvatarOptions& o) {
  EXPECT_EQ(o.avatar.initial_gaussians, 10000u);
  EXPECT_EQ(o.sh_degree, 0);
  EXPECT_EQ(o.basis, Basis::kSh);
  EXPECT_EQ(o.avatar.color_frame, ColorFrame::kWorld);
  EXPECT_EQ(o.avatar.bust, AvatarSettings::BustChoice::kNo);
  EXPECT_EQ(o.avatar.walk_every, 100);
  const TrainSettings s = o.ToSettings(0.25f);
  EXPECT_EQ(s.loss.l1, 1);
  EXPECT_EQ(s.loss.dssim, 0);
  EXPECT_EQ(s.loss.mse, 10);
  EXPECT_FLOAT_EQ(s.scale_regularizer.weight, 4);  // 1, of lengths in units of a quarter metre
  EXPECT_FLOAT_EQ(s.scale_regularizer.limit, 0.002f);
  EXPECT_EQ(s.scale_regularizer.ratio, 10);
  EXPECT_FLOAT_EQ(s.rates.position_lr_init, 1.6e-4f);
  EXPECT_FLOAT_EQ(s.rates.position_lr_final, 1.6e-6f);
  EXPECT_FLOAT_EQ(s.rates.color, 2.5e-3f);
  EXPECT_FLOAT_EQ(s.rates.opacity, 0.05f);
  EXPECT_FLOAT_EQ(s.rates.scale, 5e-3f);
  EXPECT_FLOAT_EQ(s.rates.rotation, 1e-3f);
  EXPECT_EQ(s.schedule.position_rate_steps, 30000);
  EXPECT_EQ(s.schedule.densify_from, 600);
  EXPECT_EQ(s.schedule.densify_until, 29000);
  EXPECT_EQ(s.schedule.densify_every, 100);
  EXPECT_EQ(s.schedule.opacity_reset_every, 3000);
  EXPECT_EQ(s.schedule.size_prune_after, 3000);
  EXPECT_FLOAT_EQ(s.density.gradient_threshold, 2e-4f);
  EXPECT_FLOAT_EQ(s.density.split_scale, 0.005f);
  EXPECT_FLOAT_EQ(s.density.max_scale, 0.05f);
  EXPECT_FLOAT_EQ(s.density.min_opacity, 0.005f);
  EXPECT_FALSE(s.density.shares_opacity);
  EXPECT_EQ(s.schedule.opacity_reset_share, 1);
  EXPECT_EQ(s.prune.rule, "none");
  EXPECT_EQ(s.prune.group_cap, 0);
}

TEST(AvatarPreset, SplattingAvatarsTableIsSettledInBoth) {
  const Parsed published({"--preset", "splatting-avatar", "--iterations", "30000"});
  EXPECT_EQ(published.options.avatar.system, AvatarSystem::kPublished);
  ExpectSplattingAvatar(published.options);
  const Parsed released({"--iterations", "30000", "--preset", "splatting-avatar-released"});
  EXPECT_EQ(released.options.avatar.system, AvatarSystem::kReleased);
  ExpectSplattingAvatar(released.options);
}

TEST(AvatarPreset, SplattingAvatarsLpipsNeedsANetwork) {
  for (const char* preset : {"splatting-avatar", "splatting-avatar-released"}) {
    const Parsed without({"--preset", preset}), with({"--lpips", "nets", "--preset", preset}),
        given({"--preset", preset, "--lpips", "nets", "--lambda_lpips", "0"});
    EXPECT_TRUE(without.options.OmitsLpips());
    EXPECT_EQ(without.options.ToSettings(1).crop_loss.weight, 0);
    EXPECT_FALSE(with.options.OmitsLpips());
    EXPECT_FLOAT_EQ(with.options.ToSettings(1).crop_loss.weight, 0.01f);
    EXPECT_TRUE(with.ConfigHas("train-avatar.lambda_lpips=0.01")) << with.config;
    EXPECT_TRUE(with.ConfigHas("train-avatar.lpips=\"nets\"")) << with.config;
    EXPECT_EQ(given.options.ToSettings(1).crop_loss.weight, 0);
  }
  const Parsed ours({"--lpips", "nets"});
  EXPECT_FALSE(ours.options.OmitsLpips());
  EXPECT_EQ(ours.options.ToSettings(1).crop_loss.weight, 0);
  EXPECT_FALSE(Parsed({}).options.OmitsLpips());
}

TEST(AvatarPreset, TheScheduleIsInProportionToTheRunAndTheRatesAreNot) {
  const TrainSettings s = Parsed({"--preset", "splatting-avatar"}).options.ToSettings(0.25f);
  EXPECT_EQ(s.iterations, 6000);
  EXPECT_EQ(s.schedule.densify_from, 120);
  EXPECT_EQ(s.schedule.densify_until, 5800);
  EXPECT_EQ(s.schedule.position_rate_steps, 6000);
  EXPECT_FLOAT_EQ(s.rates.position_lr_init, 1.6e-4f);
}

TEST(AvatarPreset, WhatIsGivenCountsMoreInAnyOrder) {
  const std::vector<std::string> preset{"--preset", "splatting-avatar-released"};
  const std::vector<std::string> given{"--sh_degree",
                                       "3",
                                       "--basis",
                                       "dcsh",
                                       "--color-frame",
                                       "surface",
                                       "--bust",
                                       "yes",
                                       "--gaussians",
                                       "5000",
                                       "--triangle-cap",
                                       "64",
                                       "--prune",
                                       "dcsharp",
                                       "--position_lr_init",
                                       "0.001",
                                       "--lambda_dssim",
                                       "0.2",
                                       "--densify_from_iter",
                                       "77",
                                       "--densify_until_iter",
                                       "88"};
  for (const bool first : {true, false}) {
    std::vector<std::string> arguments = first ? preset : given;
    const std::vector<std::string>& rest = first ? given : preset;
    arguments.insert(arguments.end(), rest.begin(), rest.end());
    const Parsed p(arguments);
    EXPECT_EQ(p.options.avatar.system, AvatarSystem::kReleased);
    EXPECT_EQ(p.options.basis, Basis::kDcsh);
    EXPECT_EQ(p.options.avatar.color_frame, ColorFrame::kSurface);
    EXPECT_EQ(p.options.avatar.bust, AvatarSettings::BustChoice::kYes);
    EXPECT_EQ(p.options.avatar.initial_gaussians, 5000u);
    EXPECT_EQ(p.options.prune, "dcsharp");
    const TrainSettings s = p.options.ToSettings(0.25f);
    EXPECT_EQ(s.degree, 3);
    EXPECT_EQ(s.first_degree, 3);  // all from the first step
    EXPECT_EQ(s.prune.group_cap, 64);
    EXPECT_FLOAT_EQ(s.rates.position_lr_init, 0.001f);
    EXPECT_FLOAT_EQ(s.rates.position_lr_final, 1.6e-6f);
    EXPECT_FLOAT_EQ(s.loss.l1, 0.8f);
    EXPECT_FLOAT_EQ(s.loss.dssim, 0.2f);
    EXPECT_EQ(s.loss.mse, 10);
    EXPECT_EQ(s.schedule.densify_from, 77);
    EXPECT_EQ(s.schedule.densify_until, 88);
  }
}

TEST(AvatarPreset, TheConfigurationHoldsWhatWasSettled) {
  const Parsed p({"--preset", "splatting-avatar", "--bust", "yes"});
  for (const char* line : {"train-avatar.preset=\"splatting-avatar\"",
                           "train-avatar.sh_degree=0",
                           "train-avatar.basis=\"sh\"",
                           "train-avatar.color-frame=\"world\"",
                           "train-avatar.bust=\"yes\"",
                           "train-avatar.triangle-cap=0"})
    EXPECT_TRUE(p.ConfigHas(line)) << line << " is not in\n" << p.config;
}

TEST(AvatarOptions, EarlierSpellingsAreAccepted) {
  const Parsed p({"--max_gaussians",
                  "77",
                  "--prune_lambda",
                  "0.5",
                  "--drop_bands",
                  "2",
                  "--num_downscales",
                  "3",
                  "--resolution_schedule",
                  "9",
                  "--rest_lr",
                  "0.25",
                  "--triangle_cap",
                  "5",
                  "--color_frame",
                  "world"});
  for (const char* line : {"train-avatar.max-gaussians=77",
                           "train-avatar.prune-lambda=0.5",
                           "train-avatar.drop-bands=2",
                           "train-avatar.num-downscales=3",
                           "train-avatar.resolution-schedule=9",
                           "train-avatar.rest-lr=0.25",
                           "train-avatar.triangle-cap=5",
                           "train-avatar.color-frame=\"world\""})
    EXPECT_TRUE(p.ConfigHas(line)) << line << " is not in\n" << p.config;
}

TEST(AvatarPreset, QuickIsShorterAndYields) {
  const Parsed quick({"--preset", "quick"});
  const TrainSettings s = quick.options.ToSettings(1), usual = Parsed({}).options.ToSettings(1);
  EXPECT_EQ(quick.options.iterations, 3000);
  EXPECT_EQ(quick.options.avatar.iterations, 3000);
  EXPECT_EQ(quick.options.avatar.system, AvatarSystem::kCosplat);
  EXPECT_EQ(s.schedule.num_downscales, 2);
  EXPECT_EQ(usual.schedule.num_downscales, 2);
  for (const char* other : {"3dgs", "splatting-avatar", "splatting-avatar-released"})
    EXPECT_EQ(Parsed({"--preset", other}).options.ToSettings(1).schedule.num_downscales, 0);
  EXPECT_EQ(Parsed({"--num-downscales", "0"}).options.ToSettings(1).schedule.num_downscales, 0);
  EXPECT_LT(s.density.gradient_threshold, usual.density.gradient_threshold);
  EXPECT_EQ(Parsed({"--iterations", "70", "--preset", "quick"}).options.iterations, 70);
}

TEST(AvatarOptions, AVideosImagesAreSmallForLonger) {
  const auto doubled_every = [](const std::vector<std::string>& arguments) {
    Parsed p(arguments);
    const int usual = p.options.ToSettings(1).schedule.downscale_every;
    p.options.of_video = true;
    return std::array{usual, p.options.ToSettings(1).schedule.downscale_every};
  };
  EXPECT_EQ(doubled_every({}), (std::array{600, 1200}));
  EXPECT_EQ(doubled_every({"--quality", "draft"}), (std::array{200, 400}));
  EXPECT_EQ(doubled_every({"--quality", "best"}), (std::array{1500, 1500}));
  EXPECT_EQ(doubled_every({"--resolution-schedule", "9"}), (std::array{9, 9}));
}

TEST(AvatarPreset, OthersAreRefused) {
  for (const char* name : {"default", "splattingavatar", "splatting-avatar-"})
    EXPECT_THROW(Parsed({"--preset", name}), CLI::ParseError) << name;
  EXPECT_EQ(Parsed({"--preset", "3dgs"}).options.ToSettings(1).schedule.densify_until, 15000);
  EXPECT_FALSE(Parsed({"--preset", "3dgs"}).options.ToSettings(1).density.shares_opacity);
  EXPECT_FALSE(Parsed({}).options.ToSettings(1).density.shares_opacity);
}

TEST(AvatarOptions, AFoldByTurnIsAFold) {
  const Parsed p({"--fold-by-turn"});
  EXPECT_TRUE(p.options.fold_by_turn);
  EXPECT_TRUE(p.options.fold);
  EXPECT_TRUE(p.ConfigHas("train-avatar.fold-by-turn=true")) << p.config;
  EXPECT_FALSE(Parsed({"--fold"}).options.fold_by_turn);
  const Parsed off({"--fold-by-turn=false"});  // as in the configuration of a run without it
  EXPECT_FALSE(off.options.fold);
  EXPECT_FALSE(off.options.fold_by_turn);
  EXPECT_THROW(Parsed({"--fold-by-turn=abc"}), CLI::ConversionError);
}

// A configuration file, read as the user's of `train-avatar --config FILE`.
Parsed WithConfig(const std::string& text, std::vector<std::string> more = {}) {
  const test::TemporaryFolder folder;
  WriteFileAtomically(folder / "config.ini", text);
  more.insert(more.begin(), {"--config", folder / "config.ini"});
  return Parsed(more);
}

// Before the second format, what was left open was listed with a number.
TEST(Config, AnEarlierFileMeansWhatItMeant) {
  const std::string lines =
      "train-avatar.densify_grad_threshold=0\ntrain-avatar.scaling_lr=0\n"
      "train-avatar.rest-lr=0\ntrain-avatar.position_lr_final=0\n"
      "train-avatar.densify_from_iter=-1\ntrain-avatar.densification_interval=-1\n"
      "train-avatar.num-downscales=-1\ntrain-avatar.resolution-schedule=-1\n"
      "train-avatar.test-frames=-1\ntrain-avatar.prune-to=0\ntrain-avatar.prune-lambda=0\n"
      "train-avatar.opacity_lr=0\ntrain-avatar.budget=\"none\"\n"
      "train-avatar.background=\"auto\"\ntrain-avatar.bust=\"no\"\n";
  const Parsed p = WithConfig(lines);
  const AvatarOptions& o = p.options;
  for (const auto& rate :
       {o.densify_grad_threshold, o.scaling_lr, o.rest_lr, o.position_lr_final, o.prune_lambda})
    EXPECT_FALSE(rate.has_value());
  for (const auto& steps : {o.densify_from, o.densify_every, o.num_downscales, o.test_frames})
    EXPECT_FALSE(steps.has_value());
  EXPECT_FALSE(o.prune_to.has_value());
  EXPECT_FALSE(o.background.has_value());
  EXPECT_EQ(o.opacity_lr, 0.0f) << "it could always be 0";
  EXPECT_EQ(o.avatar.bust, AvatarSettings::BustChoice::kNo);
  const TrainSettings ours = o.ToSettings(1), usual = Parsed({}).options.ToSettings(1);
  EXPECT_EQ(ours.rates.scale, usual.rates.scale);
  EXPECT_EQ(ours.density.gradient_threshold, usual.density.gradient_threshold);
  EXPECT_EQ(ours.rates.position_lr_final, usual.rates.position_lr_final);
}

// A threshold of nothing would fill the memory, so that it still stands for the preset's.
TEST(Config, AThresholdOfNothingIsThePresets) {
  EXPECT_FALSE(Parsed({"--densify_grad_threshold", "0"}).options.densify_grad_threshold);
}

// All of a run's options are given in its configuration, also those that are as they were by
// default.
TEST(Config, AQualityBesideItSaysThatItSetsNothing) {
  const Parsed p = WithConfig(Parsed({}).config, {"--quality", "best"});
  EXPECT_EQ(p.options.iterations, 6000);
  EXPECT_EQ(p.options.settled, " --iterations as it is given");
}

TEST(Config, ARateOfNothingIsOne) {
  const Parsed given({"--scaling_lr", "0", "--rest-lr", "0", "--position_lr_final", "0"});
  const TrainSettings s = given.options.ToSettings(1);
  EXPECT_EQ(s.rates.scale, 0);
  EXPECT_EQ(s.rates.RestRate(), 0);
  EXPECT_EQ(s.rates.position_lr_final, 0);
  const Parsed again = WithConfig(given.config);
  EXPECT_EQ(again.options.ToSettings(1).rates.scale, 0);
  EXPECT_EQ(again.options.ToSettings(1).rates.RestRate(), 0);
  EXPECT_EQ(again.config, given.config);
  EXPECT_EQ(WithConfig("\r\n" + given.config).options.ToSettings(1).rates.scale, 0) << "edited";
}

TEST(Config, IsReadAsItWasWritten) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{},
        {"--quality", "draft"},
        {"--preset", "quick"},
        {"--preset", "splatting-avatar"},
        {"--budget", "auto", "--mouth", "no", "--device", "auto", "--background", "white"},
        {"--prune", "opacity", "--prune-to", "4000", "--densify_from_iter", "50"}}) {
    const Parsed first(arguments), again = WithConfig(first.config);
    EXPECT_EQ(again.config, first.config);
  }
}

TEST(Quality, SetsWhatIsNotGivenAndSaysSo) {
  const Parsed draft({"--quality", "draft"});
  EXPECT_EQ(draft.options.iterations, 2000);
  EXPECT_EQ(draft.options.avatar.iterations, 2000);
  EXPECT_FLOAT_EQ(draft.options.ToSettings(1).density.gradient_threshold, 1.5e-4f);
  EXPECT_EQ(draft.options.settled, " --iterations 2000 --densify_grad_threshold 0.00015");
  EXPECT_TRUE(draft.ConfigHas("train-avatar.iterations=2000")) << draft.config;
  EXPECT_EQ(Parsed({"--quality", "standard"}).options.iterations, Parsed({}).options.iterations);
  EXPECT_EQ(Parsed({"--quality", "best"}).options.iterations, 15000);
  const Parsed given({"--quality", "best", "--iterations", "70"});
  EXPECT_EQ(given.options.iterations, 70);
  EXPECT_EQ(given.options.settled, " --iterations as it is given");
  EXPECT_EQ(Parsed({}).options.settled, "");
  EXPECT_EQ(Parsed({"--preset", "quick", "--quality", "best"}).options.iterations, 15000);
  EXPECT_THROW(Parsed({"--quality", "good"}), CLI::ParseError);
}

}  // namespace
}  // namespace cosplat
