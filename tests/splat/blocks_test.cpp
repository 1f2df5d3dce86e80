// Scenes in blocks: how they are split, what the blocks show of each other, and that a block is
// trained as the part of a scene that it is.
#include "splat/train/blocks/blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "splat/train/blocks/block_schedule.h"
#include "splat/train/blocks/block_target.h"
#include "splat/train/blocks/layers.h"
#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: small scenes

Buffer<float> RandomPoints(size_t count, const std::array<float, 3>& size, uint64_t seed = 1) {
  Rng rng{seed};
  Buffer<float> points(3 * count);
  for (size_t i = 0; i < points.size(); ++i) points[i] = size[i % 3] * rng.Normal();
  return points;
}

std::vector<size_t> CountsOf(const SceneBlocks& blocks, const Buffer<float>& points) {
  std::vector<size_t> counts(blocks.count(), 0);
  for (size_t i = 0; i < points.size(); i += 3) ++counts[blocks.BlockOf(&points[i])];
  return counts;
}

TEST(Blocks, HaveEquallyManyPoints) {
  const Buffer<float> points = RandomPoints(1000, {3, 1, 2});
  for (const size_t n : {1, 2, 3, 4, 7, 16}) {
    const SceneBlocks blocks = SplitByPlace(points.view(), n);
    ASSERT_EQ(blocks.count(), n);
    for (const size_t count : CountsOf(blocks, points))
      EXPECT_NEAR(double(count), 1000.0 / double(n), double(n)) << n;
  }
}

TEST(Blocks, AreSplitAlongTheScene) {
  const SceneBlocks blocks = SplitByPlace(RandomPoints(5000, {1, 9, 2}).view(), 2);
  EXPECT_GT(std::abs(blocks.planes[0].normal[1]), 0.98f);
  EXPECT_NEAR(blocks.planes[0].offset * blocks.planes[0].normal[1], 0, 0.5);
}

TEST(Blocks, ADistantBackgroundDoesNotDecide) {
  Buffer<float> points = RandomPoints(1000, {0.1f, 9, 2});
  Rng rng{2};
  for (int i = 0; i < 400; ++i) {
    points.push_back(1000 * rng.Normal());
    points.push_back(0);
    points.push_back(0);
  }
  EXPECT_GT(std::abs(SplitByPlace(points.view(), 2).planes[0].normal[1]), 0.9f);
}

TEST(Blocks, NeedAsManyPlaces) {
  const Buffer<float> same(300, 1.5f);
  ExpectError([&] { SplitByPlace(same.view(), 4); }, {"--blocks 4", "100 Gaussians"});
  ExpectError([&] { SplitByPlace(RandomPoints(5, {1, 1, 1}).view(), 8); }, {"--blocks"});
}

TEST(Blocks, RaysReachThemInOrder) {
  const SceneBlocks blocks = SplitByPlace(RandomPoints(2000, {3, 2, 1}).view(), 9);
  Rng rng{7};
  for (int ray = 0; ray < 200; ++ray) {
    std::array<float, 3> eye{}, to{};
    for (size_t k = 0; k < 3; ++k) eye[k] = 4 * rng.Normal(), to[k] = 4 * rng.Normal();
    const std::vector<uint32_t> order = blocks.FrontToBack(eye);
    ASSERT_EQ(std::set<uint32_t>(order.begin(), order.end()).size(), 9u);
    EXPECT_EQ(order[0], blocks.BlockOf(eye.data()));
    size_t reached = 0;
    for (int i = 0; i <= 100; ++i) {
      float p[3];
      for (size_t k = 0; k < 3; ++k) p[k] = eye[k] + float(i) / 50 * (to[k] - eye[k]);
      const auto at = std::find(order.begin(), order.end(), uint32_t(blocks.BlockOf(p)));
      EXPECT_GE(size_t(at - order.begin()), reached);
      reached = size_t(at - order.begin());
    }
  }
}

TEST(Blocks, AreReadAsWrittenOrNotAtAll) {
  const TemporaryFolder folder;
  SceneBlocks blocks = SplitByPlace(RandomPoints(200, {1, 1, 1}).view(), 5), read;
  const auto write = [&] {
    WriteStateFile(folder / "blocks", "", [&](StateArchive& a) { Serialize(a, 5, blocks); });
  };
  const auto describe = [&](StateArchive& a) { Serialize(a, 5, read); };
  write();
  StateFile(folder / "blocks").Read(describe);
  EXPECT_EQ(read.FrontToBack({1, 2, 3}), blocks.FrontToBack({1, 2, 3}));
  blocks.planes[1].side[0] = 0;  // a circle
  write();
  ExpectError([&] { StateFile(folder / "blocks").Read(describe); }, {"blocks.planes", "tree"});
}

// All that a Gaussian has, its smoothing filter and its degree too.
TEST(Blocks, PutTogetherAreWhatTheyWere) {
  Gaussians all = FirstGaussians(60, 2);
  all.antialiased = true;
  for (uint32_t i = 0; i < all.size(); ++i) {
    all.smoothing.push_back(0.01f * float(i));
    all.degrees.push_back(uint8_t(i % 3));
  }
  std::vector<uint32_t> odd, even, order;
  for (uint32_t i = 0; i < all.size(); ++i) (i % 2 == 0 ? even : odd).push_back(i);
  for (const auto* part : {&odd, &even}) order.insert(order.end(), part->begin(), part->end());
  Gaussians first = all, second = all;
  first.Gather(odd);
  second.Gather(even);
  first.Append(second);
  all.Gather(order);
  for (int a = 0; a < kAttributeCount; ++a)
    EXPECT_TRUE(SameBits(first.values[a], all.values[a])) << a;
  EXPECT_TRUE(SameBits(first.smoothing, all.smoothing));
  EXPECT_TRUE(std::equal(
      first.degrees.begin(), first.degrees.end(), all.degrees.begin(), all.degrees.end()));
}

// --- Layers
// ---------------------------------------------------------------------------------------

TEST(Layers, OfAllBlocksAreTheScene) {
  Gaussians scene = TrueScene(1, 400);
  for (float& s : scene.values[kScaleLog]) s -= 2.5f;  // hardly any reaches into another block
  const SceneBlocks blocks = SplitByPlace(scene.values[kPosition].view(), 5);
  double largest_mean = 0;
  for (const Camera& camera : Ring(5, 2.2f)) {
    LayerStack stack;
    double covered = 0;
    for (const uint32_t b : blocks.FrontToBack(camera.Center())) {
      std::vector<uint32_t> own;
      for (uint32_t i = 0; i < scene.size(); ++i)
        if (blocks.BlockOf(scene.at(kPosition, i)) == b) own.push_back(i);
      Gaussians block = scene;
      block.Gather(own);
      covered += double(stack.Add(LayerOf(Render(block, camera))));
    }
    const RenderedImage whole = Render(scene, camera);
    const Image8 expected = LayerOf(whole), found = stack.Together();
    ASSERT_EQ(found.data.size(), expected.data.size());
    double sum = 0, alpha = 0;
    for (size_t i = 0; i < found.data.size(); ++i)
      sum += std::abs(int(found.data[i]) - int(expected.data[i]));
    for (const float t : whole.transmittance) alpha += 1 - double(t);
    EXPECT_NEAR(covered, alpha / double(whole.transmittance.size()), 0.01);
    largest_mean = std::max(largest_mean, sum / double(found.data.size()));
  }
  EXPECT_LT(largest_mean, 0.3) << "of 255";
}

TEST(Layers, NothingIsNoLayer) {
  Gaussians scene = TrueScene(0);
  for (float& logit : scene.values[kOpacityLogit]) logit = -20;
  EXPECT_TRUE(LayerOf(Render(scene, Ring(1, 2.2f)[0])).empty());
  LayerStack stack;
  EXPECT_EQ(stack.Add({}), 0);
  EXPECT_TRUE(stack.Together().empty());
}

TEST(Layers, GradientsAreThoseOfWhatIsShown) {
  constexpr int kSide = 6;
  Rng rng{4};
  FrameLayers layers{Image8(kSide, kSide, 4), {}};
  for (size_t i = 0; i < layers.front.data.size(); ++i)
    layers.front.data[i] = uint8_t(rng.Below(i % 4 == 3 ? 256 : 100));
  Buffer<float> color(3 * kSide * kSide), d(color.size());
  for (float& value : color) value = rng.Uniform();
  for (float& value : d) value = rng.Normal();
  LayerModel model;
  Buffer<float> pulled = d;
  model.Backward(layers, pulled, HostStream());
  for (size_t i = 0; i < color.size(); ++i) {
    const float before = model.Forward(layers, color, HostStream())[i];
    Buffer<float> moved = color;
    moved[i] += 0.5f;
    const float slope = (model.Forward(layers, moved, HostStream())[i] - before) / 0.5f;
    EXPECT_NEAR(pulled[i], slope * d[i], 1e-5) << i;
  }
}

Image8 Uniform(const Camera& camera, std::array<uint8_t, 4> rgba) {
  Image8 layer(camera.width, camera.height, 4);
  for (size_t i = 0; i < layer.data.size(); ++i) layer.data[i] = rgba[i % 4];
  return layer;
}

// A white layer behind is a white background, a clear one in front is none.
TEST(Layers, TrainingSeesThemAsItSeesABackground) {
  const Gaussians truth = TrueScene(1);
  for (const int batch : {1, 3}) {
    TrainSettings settings = ShortRun(60, 1);
    settings.batch = batch;
    settings.exposure = true;
    std::vector<TrainFrame> frames = TargetImages(truth, Ring(6, 2.2f), false);
    settings.background = Background::kWhite;
    SceneSubject plain(frames, 1);
    const TrainingState expected = Train(settings, plain, FirstGaussians(60, 1), 60 / batch);
    for (TrainFrame& frame : frames) {
      frame.layers.behind = Uniform(frame.camera, {255, 255, 255, 255});
      frame.layers.front = Uniform(frame.camera, {0, 0, 0, 0});
    }
    settings.background = Background::kBlack;
    SceneSubject layered(frames, 1);
    const TrainingState found = Train(settings, layered, FirstGaussians(60, 1), 60 / batch);
    ASSERT_EQ(found.gaussians.size(), expected.gaussians.size());
    for (size_t i = 0; i < found.gaussians.values[kPosition].size(); ++i)
      ASSERT_NEAR(
          found.gaussians.values[kPosition][i], expected.gaussians.values[kPosition][i], 1e-4)
          << i;
  }
}

TEST(Layers, WhatIsHiddenIsNotTrained) {
  std::vector<TrainFrame> frames = TargetImages(TrueScene(1), Ring(4, 2.2f));
  for (TrainFrame& frame : frames) frame.layers.front = Uniform(frame.camera, {40, 80, 120, 255});
  SceneSubject hidden(frames, 1);
  TrainSettings settings = ShortRun(20, 1);
  settings.schedule.densify_until = 0;
  const Gaussians first = FirstGaussians(60, 1);
  EXPECT_TRUE(SameBits(Train(settings, hidden, first, 20).gaussians, first));
}

// --- Trainings that go on
// -------------------------------------------------------------------------

Image8 Pixel(std::vector<uint8_t> bytes) {
  Image8 image(1, 1, int(bytes.size()));
  std::copy(bytes.begin(), bytes.end(), image.data.begin());
  return image;
}

// Where the finished scene draws what the layers show.
Image8 TargetInOrder(const Image8& photograph,
                     const FrameLayers& others,
                     const Image8& own,
                     const Exposure& exposure = kIdentityExposure) {
  LayerStack stack;
  for (const Image8* layer : {&others.front, &own, &others.behind}) stack.Add(*layer);
  return TargetOfBlock(photograph, others, own, stack.Together(), exposure);
}

TEST(BlockTarget, IsThePhotographWhereNothingElseIs) {
  const Image8 photo = Pixel({200, 100, 50});
  const std::vector<uint8_t> expected{200, 100, 50, 255};
  // Nothing at all, the block alone, the block before others; from grey and with alpha.
  EXPECT_EQ(TargetInOrder(photo, {}, {}).data, expected);
  EXPECT_EQ(TargetInOrder(photo, {}, Pixel({9, 9, 9, 100})).data, expected);
  const FrameLayers behind{{}, Pixel({0, 0, 255, 255})};
  EXPECT_EQ(TargetInOrder(photo, behind, Pixel({9, 9, 9, 255})).data, expected);
  EXPECT_EQ(TargetInOrder(Pixel({70}), {}, {}).data, (std::vector<uint8_t>{70, 70, 70, 255}));
  EXPECT_EQ(TargetInOrder(Pixel({70, 80, 90, 51}), {}, {}).data,
            (std::vector<uint8_t>{70, 80, 90, 51}));
}

TEST(BlockTarget, IsWhatIsShownWhereOthersAreInTheWay) {
  const FrameLayers front{Pixel({10, 20, 30, 255}), {}};
  EXPECT_EQ(TargetInOrder(Pixel({200, 100, 50}), front, Pixel({9, 9, 9, 255})).data,
            (std::vector<uint8_t>{10, 20, 30, 255}));
  // As the photograph would show it.
  Exposure brighter = kIdentityExposure;
  brighter[0] = 2, brighter[7] = 0.1f;
  EXPECT_EQ(TargetInOrder(Pixel({200, 100, 50}), front, {}, brighter).data,
            (std::vector<uint8_t>{20, 46, 30, 255}));
}

// Two blocks that cover a pixel: what each is to change adds up to what is missing.
TEST(BlockTarget, SharesAddUp) {
  const Image8 photo = Pixel({200, 100, 50});
  const Image8 near = Pixel({60, 0, 30, 120}), far = Pixel({10, 90, 20, 255});
  LayerStack stack;
  stack.Add(near);
  stack.Add(far);
  const Image8 shown = stack.Together();
  const Image8 of_near = TargetInOrder(photo, {{}, far}, near);
  const Image8 of_far = TargetInOrder(photo, {near, {}}, far);
  for (size_t c = 0; c < 3; ++c) {
    const auto missing = [&](const Image8& target) { return target.data[c] - shown.data[c]; };
    EXPECT_NEAR(missing(of_near) + missing(of_far), missing(photo), 2);
    EXPECT_NEAR(missing(of_near), missing(photo) * 120 / 255.0, 1);
  }
}

// What the finished scene draws otherwise than the layers do is left as it is, in any exposure.
TEST(BlockTarget, MakesUpForWhatTheFinishedSceneLacks) {
  const Image8 own = Pixel({100, 100, 100, 255}), whole = Pixel({110, 90, 100, 255});
  EXPECT_EQ(TargetOfBlock(Pixel({150, 150, 150}), {}, own, whole, kIdentityExposure).data,
            (std::vector<uint8_t>{140, 160, 150, 255}));
  Exposure darker = kIdentityExposure;
  darker[0] = 0.5f;
  EXPECT_EQ(TargetOfBlock(Pixel({150, 150, 150}), {}, own, whole, darker).data,
            (std::vector<uint8_t>{145, 160, 150, 255}));
}

TEST(FirstIteration, TheScheduleGoesOn) {
  TrainSettings settings = ShortRun(300, 1);
  SceneSubject subject(TargetImages(TrueScene(1), Ring(4, 2.2f)), 1);
  settings.first_iteration = 200;
  Trainer trainer(settings, subject, FirstGaussians(60, 1));
  EXPECT_EQ(trainer.iteration(), 200);
  EXPECT_EQ(trainer.active_degree(), 1);
  EXPECT_EQ(trainer.Step().iteration, 201);
  EXPECT_EQ(trainer.statistics().steps, 1u);
}

TEST(FirstIteration, ExposuresGoOn) {
  TrainSettings settings = ShortRun(30, 1);
  settings.exposure = true;
  SceneSubject subject(TargetImages(TrueScene(1), Ring(4, 2.2f)), 1);
  Trainer trainer(settings, subject, FirstGaussians(60, 1));
  ExposureState exposures(4);
  exposures.value[13] = 0.25f;
  trainer.SetExposures(exposures);
  EXPECT_TRUE(SameBits(trainer.state().exposures.value, exposures.value));
}

TEST(BlockSchedule, RoundsEndAtBatchesAndTheLastOneWithTheRun) {
  EXPECT_EQ(EndOfBlockRound(0, 1000, 1), 200);
  EXPECT_EQ(EndOfBlockRound(1, 1000, 1), 600);
  EXPECT_EQ(EndOfBlockRound(kBlockRounds, 1000, 1), 1000);
  EXPECT_EQ(EndOfBlockRound(0, 1000, 7), 203);
  EXPECT_EQ(EndOfBlockRound(kBlockRounds, 1000, 7), 1000);
  EXPECT_EQ(EndOfBlockRound(0, 1, 1), 1);  // all of a very short one
}

// Neighbouring ranks are in one group, groups are of like size, and every block has one.
TEST(BlockSchedule, RanksFormGroups) {
  for (size_t ranks = 1; ranks <= 12; ++ranks) {
    for (size_t blocks = 2; blocks <= 9; ++blocks) {
      const BlockGroups groups(std::vector<int>(blocks, 100), ranks);
      EXPECT_EQ(groups.count(), std::min(ranks, blocks));
      std::vector<size_t> sizes(groups.count(), 0);
      size_t before = 0;
      for (size_t rank = 0; rank < ranks; ++rank) {
        const size_t group = groups.GroupOf(rank);
        ASSERT_LT(group, sizes.size());
        EXPECT_GE(group, before);
        before = group;
        ++sizes[group];
      }
      const auto [min, max] = std::minmax_element(sizes.begin(), sizes.end());
      EXPECT_GE(*min, 1u);
      EXPECT_LE(*max, *min + 1);
      for (size_t b = 0; b < blocks; ++b) EXPECT_LT(groups.OfBlock(b), groups.count());
    }
  }
}

TEST(BlockSchedule, GroupsHaveLikeWork) {
  const BlockGroups groups({5, 1, 4, 2}, 2);
  EXPECT_EQ(groups.OfBlock(0), 0u);
  EXPECT_EQ(groups.OfBlock(1), 0u);  // 5 + 1, 4 + 2
  EXPECT_EQ(groups.OfBlock(2), 1u);
  EXPECT_EQ(groups.OfBlock(3), 1u);
}

}  // namespace
}  // namespace cosplat
