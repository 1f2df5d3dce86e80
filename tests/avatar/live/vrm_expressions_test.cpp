// Senders that have no names of ARKit's but VRM's.
#include "avatar/live/vrm_expressions.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/street/live_source.h"

namespace cosplat {
namespace {

using test::LiveConnection;
using test::OscBundle;
using test::VmcApply;
using test::VmcValue;

constexpr int64_t kSecond = 1'000'000'000;

// Has all 52; they move nothing.
BlendshapeMap MapOfAll() {
  BlendshapeMap map;
  map.names.assign(kArkitNames.begin(), kArkitNames.end());
  map.min.assign(52, 0.0f);
  map.max.assign(52, 1.0f);
  map.offset.assign(kMappedTurns, 0.0f);
  map.matrix.assign(52 * kMappedTurns, 0.0f);
  return map;
}

TEST(VrmExpressions, BothVersionsNamesMeanTheSameInAnySpelling) {
  const VrmExpressions expressions(MapOfAll());
  const std::vector<std::string> same[] = {{"A", "aa", "a"},
                                           {"I", "ih"},
                                           {"U", "ou"},
                                           {"E", "ee"},
                                           {"O", "oh"},
                                           {"Blink", "blink", "BLINK"},
                                           {"Blink_L", "blinkLeft"},
                                           {"Blink_R", "blinkRight"},
                                           {"Joy", "happy", "JOY"},
                                           {"Angry", "angry"},
                                           {"Sorrow", "sad"},
                                           {"Fun", "relaxed"},
                                           {"Surprised", "surprised"},
                                           {"LookUp", "lookUp"},
                                           {"LookDown", "lookDown"},
                                           {"LookLeft", "lookLeft"},
                                           {"LookRight", "lookRight"}};
  EXPECT_EQ(expressions.size(), std::size(same));
  for (size_t i = 0; i < std::size(same); ++i)
    for (const std::string& name : same[i]) EXPECT_EQ(expressions.Find(name), int(i)) << name;
  for (const char* name : {"", "Neutral", "jawOpen", "B", "Blinks", "Joyful"})
    EXPECT_EQ(expressions.Find(name), -1) << name;
}

// A name that ARKit does not have would be left out without a word.
TEST(VrmExpressions, EveryOneIsOfScoresThatExist) {
  const VrmExpressions expressions(MapOfAll());
  const size_t parts[] = {3, 5, 3, 5, 3, 2, 1, 1, 6, 6, 4, 4, 6, 2, 2, 2, 2};
  for (size_t i = 0; i < expressions.size(); ++i) {
    std::vector<float> weights(expressions.size()), half(52), whole(52);
    weights[i] = 0.5f;
    expressions.Add(weights, half);
    weights[i] = 1;
    expressions.Add(weights, whole);
    EXPECT_EQ(size_t(std::count_if(whole.begin(), whole.end(), [](float x) { return x > 0; })),
              parts[i])
        << i;
    for (size_t c = 0; c < 52; ++c) EXPECT_FLOAT_EQ(half[c], whole[c] / 2);
    expressions.Add(std::vector<float>(expressions.size(), 1.0f), whole);
    for (const float score : whole) EXPECT_LE(score, 1);
  }
}

TEST(VrmExpressions, MoveAnyAvatarsJawLidsAndGaze) {
  FlameModel flame;
  flame.expression_count = 4;
  flame.has_eyelids = true;
  LiveSourceOptions options;
  options.flame = &flame;
  LiveConnection live("vmc", options);
  live.Send(OscBundle({VmcValue("A", 1),
                       VmcValue("Blink_L", 0.75f),
                       VmcValue("LookLeft", 1),
                       VmcValue("Joy", 1),
                       VmcApply()}));
  ASSERT_TRUE(live.Poll());
  EXPECT_FLOAT_EQ(live.JawOpen(), 0.6f);
  EXPECT_EQ(live.frame.params.expression, (std::vector<float>{0, 0, 0.75f, 0}));
  EXPECT_GT(live.frame.params.pose[3][1], 0.1f);  // to the subject's left
  EXPECT_GT(live.frame.params.pose[4][1], 0.1f);
  EXPECT_EQ(live.Notes(), "ignored blendshapes: Joy (1)");  // the general map has no smile
  live.Send(OscBundle({VmcValue("A", 0.5f), VmcApply()}));  // and keeps the rest
  ASSERT_TRUE(live.Poll(1));
  EXPECT_FLOAT_EQ(live.JawOpen(), 0.3f);
  EXPECT_EQ(live.frame.params.expression[2], 0.75f);
}

TEST(VrmExpressions, ATrackersOwnScoresStandAboveThem) {
  LiveConnection live("vmc");
  const auto send = [&](float jaw, int64_t now_ns) {
    live.Send(OscBundle({VmcValue("A", 1), VmcValue("jawOpen", jaw), VmcApply()}));
    ASSERT_TRUE(live.Poll(now_ns));
  };
  send(0, 0);  // all of the sender's model each frame, zeros too
  EXPECT_FLOAT_EQ(live.JawOpen(), 0.6f);
  send(0.25f, 1);
  EXPECT_FLOAT_EQ(live.JawOpen(), 0.25f);
  EXPECT_EQ(live.Notes(), "ignored blendshapes: VRM's expressions beside scores (1)");
  send(0, kSecond);
  EXPECT_EQ(live.JawOpen(), 0);
  send(0, 3 * kSecond);  // another tracker
  EXPECT_FLOAT_EQ(live.JawOpen(), 0.6f);
}

}  // namespace
}  // namespace cosplat
