// The crop loss in training: where crops are, that its gradient is added where it belongs, and that
// it is off by default.
#include "splat/train/loss/crop_loss.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <set>

#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/squared_distance.h"

namespace cosplat {
namespace {

using namespace test;

bool Contains(const Crop& crop, int x, int y) {
  return x >= crop.x && x < crop.x + crop.width && y >= crop.y && y < crop.y + crop.height;
}

TEST(CropLoss, CropsAreAnywhereInAnImageWithoutAMask) {
  const Image8 image(20, 10, 3);
  Rng rng{1};
  std::set<std::pair<int, int>> places;
  for (int i = 0; i < 2000; ++i) {
    const Crop crop = DrawCrop(image, 8, rng);
    EXPECT_EQ(crop.width, 8);
    EXPECT_EQ(crop.height, 8);
    places.insert({crop.x, crop.y});
  }
  EXPECT_EQ(places.size(), 13u * 3u);
  EXPECT_EQ(places.begin()->first, 0);
  EXPECT_EQ(places.rbegin()->first, 12);
}

TEST(CropLoss, CropsAreWhereTheMaskIs) {
  Image8 image(40, 30, 4);
  for (int y = 4; y < 9; ++y)  // 5 rows, 20 columns
    for (int x = 15; x < 35; ++x) image.at(x, y, 3) = 200;
  image.at(0, 29, 3) = 10;  // next to nothing
  Rng rng{1};
  std::set<std::pair<int, int>> places;
  for (int i = 0; i < 2000; ++i) {
    const Crop crop = DrawCrop(image, 8, rng);
    places.insert({crop.x, crop.y});
    EXPECT_GE(crop.x, 15);
    EXPECT_LE(crop.x + 8, 35);
    for (const int y : {4, 8}) EXPECT_TRUE(Contains(crop, crop.x, y)) << "all its rows";
  }
  EXPECT_EQ(places.size(), 13u * 4u);
}

TEST(CropLoss, DrawsAreAsManyForAnyImage) {
  Image8 corner(40, 30, 4);
  corner.at(39, 29, 3) = 255;
  for (const Image8& image : {Image8(5, 6, 3), Image8(100, 90, 1), Image8(40, 30, 4), corner}) {
    Rng rng{1};
    const Crop crop = DrawCrop(image, 8, rng);
    EXPECT_EQ(rng.state, Rng{1}.After(2).state);
    EXPECT_EQ(crop.width, std::min(8, image.width));
    EXPECT_LE(crop.x + crop.width, image.width);
    EXPECT_LE(crop.y + crop.height, image.height);
  }
  Rng rng{1};
  EXPECT_TRUE(Contains(DrawCrop(corner, 8, rng), 39, 29));
}

TEST(CropLoss, CroppedIsThePart) {
  Image8 image(5, 4, 2);
  for (size_t i = 0; i < image.data.size(); ++i) image.data[i] = uint8_t(i);
  const Image8 part = Cropped(image, {2, 1, 3, 2});
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 3; ++x)
      for (int c = 0; c < 2; ++c) EXPECT_EQ(part.at(x, y, c), image.at(x + 2, y + 1, c));
}

struct ShortTraining {
  explicit ShortTraining(bool with_alpha = true)
      : subject(TargetImages(TrueScene(1), Ring(4, 2.2f), with_alpha), 1) {
    settings.background = Background::kRandom;
  }
  std::vector<double> Losses(int steps) {
    Trainer trainer(settings, subject, FirstGaussians(100, 1));
    std::vector<double> losses;
    for (int i = 0; i < steps; ++i) losses.push_back(trainer.Step().loss);
    state = trainer.state();
    return losses;
  }
  SceneSubject subject;
  TrainSettings settings = ShortRun(300, 1);
  TrainingState state;
};

TEST(CropLoss, TheWholeImagesSquaredDistanceIsTheMse) {
  for (const bool with_alpha : {true, false}) {
    ShortTraining crop(with_alpha), mse(with_alpha);
    for (ShortTraining* run : {&crop, &mse}) run->settings.background = Background::kWhite;
    crop.settings.crop_loss = {3, 1000, std::make_shared<SquaredDistance>()};
    mse.settings.loss.mse = 3;
    const std::vector<double> a = crop.Losses(15), b = mse.Losses(15);
    // The order of frames is drawn, as crops are: that of the first pass is the same. Measured:
    // 6e-5 apart after three steps.
    EXPECT_NEAR(a[0], b[0], 1e-6 * b[0]);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(a[i], b[i], 5e-4 * b[i]) << i;
    EXPECT_NE(a[0], ShortTraining(with_alpha).Losses(1)[0]);
  }
}

TEST(CropLoss, BitsDependOnTheSeedAlone) {
  std::vector<TrainingState> states;
  for (const int threads : {1, 4, 2}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    ShortTraining run;
    run.settings.crop_loss = {1, 16, std::make_shared<SquaredDistance>()};
    run.Losses(40);
    states.push_back(run.state);
  }
  EXPECT_TRUE(SameBits(states[0], states[1]));
  EXPECT_TRUE(SameBits(states[0], states[2]));
}

TEST(CropLoss, ImagesAndCropsThatAreTooSmall) {
  ShortTraining run;
  run.settings.crop_loss = {1, 64, std::make_shared<SquaredDistance>(49)};
  test::ExpectError([&] { run.Losses(1); }, {"training frames", "49x49", "48"});
  run.settings.crop_loss = {1, 20, std::make_shared<SquaredDistance>(21)};
  test::ExpectError([&] { run.Losses(1); }, {"training frames", "21x21", "20"});
}

// Images that would become smaller than the network takes are not made smaller.
TEST(CropLoss, ReducedImagesStayLargeEnough) {
  SceneSubject subject(TargetImages(TrueScene(1), Ring(3, 2.2f, 208)), 1);
  TrainSettings settings = ShortRun(300, 1);
  settings.schedule.num_downscales = 1;
  settings.crop_loss = {1, 200, std::make_shared<SquaredDistance>(150)};
  EXPECT_NO_THROW(Train(settings, subject, FirstGaussians(20, 1), 3));
}

TEST(CropLoss, ALossThatIsNotFiniteEndsTheRun) {
  ShortTraining run;
  run.settings.crop_loss = {INFINITY, 16, std::make_shared<SquaredDistance>()};
  test::ExpectError([&] { run.Losses(1); }, {"iteration 1", "the loss is not finite"});
}

}  // namespace
}  // namespace cosplat
