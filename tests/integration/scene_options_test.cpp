// apps/cosplat/options/scene_options.h and train_options.h: what a scene's preset settles.
#include "apps/cosplat/options/scene_options.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

// docs/reference.md says what each is worth.
TEST(ScenePreset, TheDefaultImprovesOn3dgs) {
  TrainOptions o;
  const TrainSettings ours = o.ToSettings(1);
  EXPECT_FLOAT_EQ(ours.rates.scale, 1e-2f);
  EXPECT_FLOAT_EQ(ours.rates.color, 2.5e-3f);
  EXPECT_FLOAT_EQ(ours.rates.opacity, 0.025f);
  EXPECT_FLOAT_EQ(ours.rates.rotation, 2e-3f);
  EXPECT_GT(ours.color_curvature, 0);
  EXPECT_TRUE(ours.density.shares_opacity);
  EXPECT_TRUE(std::isinf(ours.density.max_scale));
  EXPECT_TRUE(ours.schedule.ResetsOpacityAt(3000));
  EXPECT_FALSE(ours.schedule.ResetsOpacityAt(6000));
  EXPECT_EQ(ours.schedule.DownscaleAt(1), 4);
  EXPECT_FLOAT_EQ(ours.schedule.RateShare(30000), 0.2f);
  o.iterations = 7000;
  EXPECT_FLOAT_EQ(o.ToSettings(1).rates.color, 1e-2f);
  o.iterations = 30000;
  o.scaling_lr = 3e-3f;
  o.feature_lr = 4e-3f;
  o.opacity_lr = 0.01f;
  o.rotation_lr = 5e-4f;
  o.num_downscales = 0;
  o.opacity_reset_every = 1000;
  const TrainSettings given = o.ToSettings(1);
  EXPECT_FLOAT_EQ(given.rates.scale, 3e-3f);
  EXPECT_FLOAT_EQ(given.rates.color, 4e-3f);
  EXPECT_FLOAT_EQ(given.rates.RestRate(), 2e-4f);
  EXPECT_FLOAT_EQ(given.rates.opacity, 0.01f);
  EXPECT_FLOAT_EQ(given.rates.rotation, 5e-4f);
  EXPECT_EQ(given.schedule.DownscaleAt(1), 1);
  EXPECT_FLOAT_EQ(given.density.gradient_threshold, 2e-4f);
  o.antialiasing = true;
  EXPECT_FLOAT_EQ(o.ToSettings(1).density.gradient_threshold, 1.6e-4f);
  EXPECT_EQ(o.ToSettings(1).LossAt(30000).mse, 0);
  o.renderings = true;
  EXPECT_FLOAT_EQ(o.ToSettings(1).density.gradient_threshold, 1.5e-4f);
  EXPECT_EQ(o.ToSettings(1).LossAt(15000).mse, 0);
  EXPECT_EQ(o.ToSettings(1).LossAt(15001).mse, 15);
  o.densify_grad_threshold = 3e-4f;
  EXPECT_FLOAT_EQ(o.ToSettings(1).density.gradient_threshold, 3e-4f);
  EXPECT_TRUE(given.schedule.ResetsOpacityAt(14000))
      << "an interval that is given holds throughout";
}

TEST(ScenePreset, RefusesOptionsThatExcludeEachOther) {
  TrainOptions o;
  o.densify_from = 900;
  o.densify_until = 300;
  test::ExpectError([&] { o.ToSettings(1); },
                    {"--densify_from_iter 900", "--densify_until_iter 300"});
  o.densify_from.reset();
  o.ToSettings(1);  // 3DGS's way to add none
  o.white_background = true;
  o.ResolveBackground(Background::kBlack);
  EXPECT_EQ(o.background, Background::kWhite);
  o.background = Background::kBlack;
  test::ExpectError([&] { o.ResolveBackground(Background::kBlack); }, {"-w", "two backgrounds"});
}

TEST(ScenePreset, BlocksLearnAt3dgsRates) {
  SceneTrainOptions o;
  o.iterations = 7000;
  EXPECT_FLOAT_EQ(o.ToSettings(1).rates.color, 1e-2f);
  o.blocks = 2;
  const TrainSettings s = o.ToSettings(1);
  EXPECT_FLOAT_EQ(s.rates.color, 2.5e-3f);
  EXPECT_FLOAT_EQ(s.rates.opacity, 0.05f);
  EXPECT_FLOAT_EQ(s.rates.scale, 1e-2f);
  EXPECT_EQ(s.color_curvature, 0);
  o.feature_lr = 4e-3f;
  EXPECT_FLOAT_EQ(o.ToSettings(1).rates.color, 4e-3f);
}

TEST(ScenePreset, The3dgsOneIs3dgs) {
  TrainOptions o;
  o.preset = Preset::k3dgs;
  o.renderings = true;
  const TrainSettings s = o.ToSettings(1);
  EXPECT_FLOAT_EQ(s.rates.scale, 5e-3f);
  EXPECT_FLOAT_EQ(s.rates.color, 2.5e-3f);
  EXPECT_FLOAT_EQ(s.rates.opacity, 0.05f);
  EXPECT_FLOAT_EQ(s.rates.rotation, 1e-3f);
  EXPECT_FLOAT_EQ(s.density.gradient_threshold, 2e-4f);
  EXPECT_EQ(s.color_curvature, 0);
  EXPECT_FALSE(s.density.shares_opacity);
  EXPECT_FLOAT_EQ(s.density.max_scale, 0.1f);
  EXPECT_EQ(s.LossAt(30000).mse, 0);
  EXPECT_TRUE(s.schedule.ResetsOpacityAt(12000));
  EXPECT_EQ(s.schedule.DownscaleAt(1), 1);
  EXPECT_EQ(s.schedule.RateShare(30000), 1);
}

// docs/reference.md has what it gains, and where it loses.
TEST(ScenePreset, ShortRunsCutAcrossTheLongestAxis) {
  SceneTrainOptions o;
  o.renderings = true;
  o.iterations = 7500;
  EXPECT_TRUE(o.ToSettings(1).density.cuts_long_axis);
  EXPECT_FLOAT_EQ(o.ToSettings(1).density.gradient_threshold, 1.75e-4f);
  o.iterations = 7501;
  EXPECT_FALSE(o.ToSettings(1).density.cuts_long_axis);
  EXPECT_FLOAT_EQ(o.ToSettings(1).density.gradient_threshold, 1.5e-4f);
  o.iterations = 2000;
  o.renderings = false;
  EXPECT_TRUE(o.ToSettings(1).density.cuts_long_axis);
  EXPECT_FLOAT_EQ(o.ToSettings(1).density.gradient_threshold, 2e-4f);
  SceneTrainOptions filtered = o, in_blocks = o, published = o;
  filtered.antialiasing = true;
  in_blocks.blocks = 2;
  published.preset = Preset::k3dgs;
  for (const SceneTrainOptions* other : {&filtered, &in_blocks, &published})
    EXPECT_FALSE(other->ToSettings(1).density.cuts_long_axis);
}

}  // namespace
}  // namespace cosplat
