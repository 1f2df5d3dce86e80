#include "flame/fit/landmark_scores.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cosplat {
namespace {

// The points that scores are made of, in a schematic face: eyes 120 px apart, turned by `roll`.
DetectedFace Schematic(double gape, double lids, double gaze, double roll = 0) {
  DetectedFace face;
  face.points.assign(478, {256, 256});
  const auto put = [&](size_t point, double x, double y) {
    face.points[point] = {256 + std::cos(roll) * x - std::sin(roll) * y,
                          256 + std::sin(roll) * x + std::cos(roll) * y};
  };
  const size_t corners[2][2] = {{33, 133}, {263, 362}}, upper[] = {159, 386}, lower[] = {145, 374};
  const size_t iris[] = {468, 473}, brow[] = {52, 282}, inner_brow[] = {55, 285},
               mouth[] = {61, 291};
  for (int i = 0; i < 2; ++i) {
    const double side = i == 0 ? -1 : 1;
    put(corners[i][0], 60 * side, 0);
    put(corners[i][1], 20 * side, 0);
    put(upper[i], 40 * side, -lids / 2);
    put(lower[i], 40 * side, lids / 2);
    put(iris[i], 40 * side + gaze, 0);
    put(brow[i], 45 * side, -40);
    put(inner_brow[i], 20 * side, -35);
    put(mouth[i], 35 * side, 90);
  }
  put(168, 0, 0), put(10, 0, -100), put(152, 0, 150), put(2, 0, 60);
  put(13, 0, 90 - gape / 2), put(14, 0, 90 + gape / 2);
  put(0, 0, 80 - gape / 2), put(17, 0, 100 + gape / 2);
  return face;
}

TEST(LandmarkScores, FollowTheFace) {
  const auto rest = ScoresOf(Schematic(0, 14, 0), LandmarkSet::kMediapipe478);
  EXPECT_EQ(rest.size(), 24u);
  EXPECT_EQ(rest.at("jawOpen"), 0);
  EXPECT_NEAR(rest.at("eyeBlinkLeft"), 0, 1e-6);
  const auto open = ScoresOf(Schematic(22.5, 0, 5), LandmarkSet::kMediapipe478);
  EXPECT_NEAR(open.at("jawOpen"), 0.5, 1e-6);
  EXPECT_EQ(open.at("eyeBlinkLeft"), 1);
  // To the image's right, which is the subject's left.
  EXPECT_NEAR(open.at("eyeLookOutLeft"), 0.5, 1e-6);
  EXPECT_NEAR(open.at("eyeLookInRight"), 0.5, 1e-6);
  EXPECT_EQ(open.at("eyeLookInLeft"), 0);
}

TEST(LandmarkScores, DoNotDependOnRoll) {
  const auto upright = ScoresOf(Schematic(20, 8, 4), LandmarkSet::kMediapipe478);
  const auto rolled = ScoresOf(Schematic(20, 8, 4, 0.5), LandmarkSet::kMediapipe478);
  for (const auto& [name, score] : upright) EXPECT_NEAR(rolled.at(name), score, 1e-6) << name;
}

TEST(LandmarkScores, AreWithinZeroAndOneAndNeedMediapipesPoints) {
  for (const auto& [name, score] : ScoresOf(Schematic(400, 300, 90), LandmarkSet::kMediapipe478)) {
    EXPECT_GE(score, 0) << name;
    EXPECT_LE(score, 1) << name;
  }
  EXPECT_EQ(ScoresOf(Schematic(0, 9, 0), LandmarkSet::kMediapipe468).count("eyeLookUpLeft"), 0u);
  EXPECT_TRUE(ScoresOf(Schematic(0, 9, 0), LandmarkSet::kOther).empty());
  DetectedFace nowhere;
  nowhere.points.assign(478, {3, 3});
  EXPECT_TRUE(ScoresOf(nowhere, LandmarkSet::kMediapipe478).empty());
}

}  // namespace
}  // namespace cosplat
