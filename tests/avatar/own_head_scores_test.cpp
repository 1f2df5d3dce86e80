// Our own head by face trackers' scores: what each of ARKit's names does to it.
#include <gtest/gtest.h>

#include <cmath>

#include "assets/head/procedural_head.h"
#include "avatar/model/blendshape_map.h"
#include "flame/eyelids.h"
#include "flame/pose.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

class OwnHeadScores : public ::testing::Test {
 protected:
  // Where the scores take MediaPipe's landmark from rest: outwards (of the right side: to -x), up
  // and forward, millimetres.
  std::array<double, 3> Shift(int landmark, const BlendshapeScores& scores) {
    const auto at = PlaceOf(landmark, scores), rest = PlaceOf(landmark, {});
    const double side = rest[0] < -1e-3 ? -1 : 1;
    return {1e3 * side * (at[0] - rest[0]), 1e3 * (at[1] - rest[1]), 1e3 * (at[2] - rest[2])};
  }
  double Distance(int a, int b, const BlendshapeScores& scores) {
    const auto p = PlaceOf(a, scores), q = PlaceOf(b, scores);
    return 1e3 * std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
  }

  static const FlameModel& Head() {
    static const FlameModel head = MakeHeadForPeople();
    return head;
  }

 private:
  std::array<double, 3> PlaceOf(int landmark, const BlendshapeScores& scores) {
    FlameParams params;
    ApplyBlendshapes(GeneralBlendshapeMap(&Head()), scores, params);
    std::vector<float> vertices;
    FlamePoser<float>(Head(), {}).Forward(FlamePoser<float>::ParametersOf(params), vertices);
    std::array<double, 3> place{};
    for (const EmbeddedLandmark& point : Head().landmarks)
      for (size_t k = 0; point.landmark == landmark && k < 3; ++k)
        for (size_t i = 0; i < 3; ++i)
          place[i] += point.barycentric[k] * vertices[3 * size_t(point.vertices[k]) + i];
    return place;
  }
};

// MediaPipe's, of the face's left side.
constexpr int kCorner = 291, kOuterBrow = 276, kInnerBrow = 285, kUpperLip = 0, kLowerLip = 17,
              kUpperLid = 386, kLowerLid = 374, kUpperRim = 13, kLowerRim = 14;

TEST_F(OwnHeadScores, KnowAllOfArkitsNamesButTheTongue) {
  const BlendshapeMap map = GeneralBlendshapeMap(&Head());
  EXPECT_EQ(ProblemOf(map), "");
  for (const std::string_view name : kArkitNames)
    EXPECT_EQ(FindBlendshape(map, name) >= 0, name != "tongueOut") << name;
}

TEST_F(OwnHeadScores, DoWhatTheirNamesSay) {
  const auto up = [&](int landmark, const char* name) { return Shift(landmark, {{name, 1}})[1]; };
  const auto outwards = [&](int landmark, const char* name) {
    return Shift(landmark, {{name, 1}})[0];
  };
  EXPECT_GT(up(kCorner, "mouthSmileLeft"), 5);
  EXPECT_GT(outwards(kCorner, "mouthSmileLeft"), 3);
  EXPECT_LT(up(kCorner, "mouthFrownLeft"), -3);
  EXPECT_GT(outwards(kCorner, "mouthStretchLeft"), 4);
  EXPECT_LT(outwards(kCorner, "mouthPucker"), -3);
  EXPECT_GT(outwards(kCorner, "mouthLeft"), 5);
  EXPECT_LT(outwards(kCorner, "mouthRight"), -5);
  EXPECT_GT(up(kUpperLip, "mouthFunnel"), 2);
  EXPECT_LT(up(kLowerLip, "mouthFunnel"), -2);
  EXPECT_GT(up(kUpperLip, "mouthShrugUpper"), 3);
  EXPECT_GT(up(kOuterBrow, "browOuterUpLeft"), 3);
  EXPECT_GT(up(kInnerBrow, "browInnerUp"), 4);
  EXPECT_LT(up(kInnerBrow, "browDownLeft"), -2);
  EXPECT_GT(up(kUpperLid, "eyeWideLeft"), 1.5);
  EXPECT_LT(up(kUpperLid, "eyeLookDownLeft"), -3);
  EXPECT_GT(up(kLowerLid, "eyeSquintLeft"), 1);
  EXPECT_LT(Distance(kUpperLid, kLowerLid, {{"eyeBlinkLeft", 1}}),
            0.25 * Distance(kUpperLid, kLowerLid, {}));
  EXPECT_GT(Shift(152, {{"jawForward", 1}})[2], 5);  // the chin
}

TEST_F(OwnHeadScores, MoveTheirOwnSide) {
  constexpr std::pair<int, int> kPoints[] = {{kCorner, 61}, {kOuterBrow, 46}, {kUpperLid, 159}};
  for (const char* name : {"mouthSmile", "mouthFrown", "browOuterUp", "eyeBlink", "noseSneer"})
    for (const auto& [left, right] : kPoints) {
      const auto of_left = Shift(left, {{std::string(name) + "Left", 1}});
      const auto of_right = Shift(right, {{std::string(name) + "Right", 1}});
      const auto other = Shift(right, {{std::string(name) + "Left", 1}});
      for (size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(of_left[i], of_right[i], 0.7) << name;
        EXPECT_NEAR(other[i], 0, 0.7) << name;
      }
    }
}

TEST_F(OwnHeadScores, LipsMeetOverAnOpenJaw) {
  const double open = Distance(kUpperRim, kLowerRim, {{"jawOpen", 1}});
  EXPECT_GT(open, 25);
  EXPECT_LT(Distance(kUpperRim, kLowerRim, {{"jawOpen", 1}, {"mouthClose", 1}}), 2);
  EXPECT_LT(Distance(kUpperRim, kLowerRim, {{"jawOpen", 0.5f}, {"mouthClose", 0.5f}}), 4);
}

TEST_F(OwnHeadScores, NamesComeBackFromTheFile) {
  const test::TemporaryFolder folder;
  WriteFlameModelNpz(folder / "head.npz", Head());
  const FlameModel read = LoadFlameModel(folder / "head.npz");
  EXPECT_EQ(read.expression_names, Head().expression_names);
  EXPECT_TRUE(read.has_eyelids);
  EXPECT_EQ(WithEyelids(read).expression_count, read.expression_count) << "it has them already";
  EXPECT_EQ(read.expression_scores, Head().expression_scores);
}

}  // namespace
}  // namespace cosplat
