// Which shots of a video that is cut show one person from one distance.
#include "flame/fit/choose_shots.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace cosplat {
namespace {

FaceLook Look(int frame, double size, float color) {
  return {frame, size, std::vector<float>(48, color)};
}

TEST(ShotsBetween, LeavesOutWhatIsTooShort) {
  const auto counts = [](const std::vector<int>& cuts, int frames, double rate) {
    std::vector<int> all;
    for (const Shot& shot : ShotsBetween(cuts, frames, rate)) all.push_back(shot.count());
    return all;
  };
  EXPECT_EQ(counts({}, 50, 25), (std::vector<int>{50}));
  EXPECT_EQ(counts({20, 23, 40}, 50, 25), (std::vector<int>{20, 17, 10}));
  EXPECT_EQ(counts({}, 1, 25), (std::vector<int>{1}));
  EXPECT_EQ(counts({1, 2}, 3, 25), (std::vector<int>{1, 1, 1})) << "nothing is longer";
}

TEST(SampleShots, SpreadsThemAndForgetsNone) {
  EXPECT_EQ(SampleShots({{0, 100}}, 4), (std::vector<int>{12, 37, 62, 87}));
  EXPECT_EQ(SampleShots({{0, 3}}, 64), (std::vector<int>{0, 1, 2}));
  const std::vector<int> frames = SampleShots({{0, 900}, {950, 960}, {960, 961}}, 10);
  EXPECT_TRUE(std::is_sorted(frames.begin(), frames.end()));
  const auto within = [&](int begin, int end) {
    return std::count_if(
        frames.begin(), frames.end(), [&](int f) { return begin <= f && f < end; });
  };
  EXPECT_EQ(within(0, 900), 10);
  EXPECT_EQ(within(950, 960), 2);
  EXPECT_EQ(within(960, 961), 1);
}

TEST(ShotsAlike, ShowOneFaceFromOneDistance) {
  const std::vector<Shot> shots{{0, 100}, {100, 160}, {160, 300}, {300, 330}, {330, 400}};
  const std::vector<FaceLook> looks{
      Look(10, 200, 100),
      Look(120, 200, 140),  // another person
      Look(170, 210, 95),
      // 310: a thing
      Look(350, 320, 100),  // from nearer
  };
  EXPECT_EQ(ShotsAlike(shots, looks), (std::vector<size_t>{0, 2}));
  EXPECT_EQ(ShotsAlike(shots, {looks[1]}), (std::vector<size_t>{1}));
  EXPECT_EQ(ShotsAlike(shots, {}), std::vector<size_t>{});
}

TEST(ShotsAlike, AreSoByAThird) {
  const std::vector<Shot> shots{{0, 100}, {100, 200}, {200, 300}};
  // It walks up to the camera, in the last.
  EXPECT_EQ(ShotsAlike(shots,
                       {Look(10, 200, 100),
                        Look(110, 300, 100),
                        Look(210, 195, 100),
                        Look(250, 250, 100),
                        Look(290, 310, 100)}),
            (std::vector<size_t>{0, 1, 2}));
}

}  // namespace
}  // namespace cosplat
