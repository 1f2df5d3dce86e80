#include "avatar/live/face_scores.h"

#include <gtest/gtest.h>

#include <cmath>

#include "avatar/live/source.h"
#include "avatar/live/udp_socket.h"
#include "avatar/live/vmc_frame.h"
#include "splat/base/rng.h"
#include "tests/avatar/live/osc_builder.h"

namespace cosplat {
namespace {

// Of 52 random scores to 60 coefficients and the turns, as fitted ones are.
BlendshapeMap RandomMap() {
  Rng rng{1};
  BlendshapeMap map;
  map.names.assign(kArkitNames.begin(), kArkitNames.end());
  map.min.assign(52, 0.0f);
  map.max.assign(52, 1.0f);
  map.offset.resize(60 + kMappedTurns);
  map.matrix.resize(52 * map.offset.size());
  for (float& x : map.offset) x = 0.1f * rng.Normal();
  for (float& x : map.matrix) x = 0.1f * rng.Normal();
  return map;
}

TEST(FaceScores, MakeTheFaceAgain) {
  const BlendshapeMap map = RandomMap();
  Rng rng{2};
  std::vector<float> scores(52);
  for (float& score : scores) score = rng.Uniform() < 0.5f ? 0 : rng.Uniform();
  FlameParams face, again;
  ApplyBlendshapes(map, scores, face);
  ApplyBlendshapes(map, ScoresOf(map, face), again);
  ASSERT_EQ(again.expression.size(), face.expression.size());
  for (size_t e = 0; e < face.expression.size(); ++e)
    EXPECT_NEAR(again.expression[e], face.expression[e], 0.02f);
  for (size_t joint = 2; joint < 5; ++joint)
    for (size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(again.pose[joint][axis], face.pose[joint][axis], 0.002f);
}

TEST(FaceScores, AreWithinBoundsWhateverTheFace) {
  FlameParams face;
  face.pose[2] = {9, 0.05f, 0};  // more than the jaw opens by any score, and to the left
  const BlendshapeScores scores = ScoresOf(GeneralBlendshapeMap(nullptr), face);
  EXPECT_EQ(scores.at("jawOpen"), 1);
  EXPECT_NEAR(scores.at("jawLeft"), 0.5f, 1e-3f);
  EXPECT_EQ(scores.at("jawRight"), 0);
  for (const auto& [name, score] : ScoresOf(GeneralBlendshapeMap(nullptr), {}))
    EXPECT_EQ(score, 0) << name;
}

TEST(FaceScores, ByVmcTheHeadComesBackAsItWas) {
  const auto source = OpenLiveSource("vmc://:0");
  FlameParams face;
  face.pose[0] = {0.1f, -0.2f, 0.3f};
  face.pose[1] = {-0.3f, 0.1f, 0.2f};
  face.pose[2] = {0.25f, 0, 0};
  face.pose[3] = {-0.1f, 0.2f, 0};
  UdpSocket sender = UdpSocket::ConnectTo(ParseDriveAddress(test::AddressOf(*source)));
  ASSERT_TRUE(sender.Send(
      WriteVmcFrame(ScoresOf(GeneralBlendshapeMap(nullptr), face), face.pose[0], face.pose[1])));
  LiveFrame frame;
  ASSERT_TRUE(source->Poll(0, frame)) << source->Counts().last_problem;
  for (size_t joint = 0; joint < 4; ++joint)
    for (size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(frame.params.pose[joint][axis], face.pose[joint][axis], 1e-3f) << joint;
  EXPECT_EQ(NotesOf(source->Counts()), "");
}

}  // namespace
}  // namespace cosplat
