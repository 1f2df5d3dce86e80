// What VMC senders do besides what the protocol's page shows.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/street/live_source.h"

namespace cosplat {
namespace {

using test::LiveConnection;
using test::OscBundle;
using test::OscFloat;
using test::OscText;
using test::OscWord;
using test::VmcApply;
using test::VmcBone;
using test::VmcValue;

constexpr int64_t kSecond = 1'000'000'000;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const float kSine = std::sin(0.1f), kCosine = std::cos(0.1f);  // turns by 0.2 rad

// Unity's axes: +y turns towards +x, which is the subject's right; +x turns forward down.
std::string ToTheRight(const std::string& bone) { return VmcBone(bone, {0, kSine, 0, kCosine}); }
std::string Down(const std::string& bone) { return VmcBone(bone, {kSine, 0, 0, kCosine}); }
std::string Straight(const std::string& bone) { return VmcBone(bone, {0, 0, 0, 1}); }

void ExpectTurn(const LiveFrame& frame, size_t joint, float down, float to_the_left) {
  EXPECT_NEAR(frame.params.pose[joint][0], down, 1e-5f) << "joint " << joint;
  EXPECT_NEAR(frame.params.pose[joint][1], to_the_left, 1e-5f) << "joint " << joint;
  EXPECT_NEAR(frame.params.pose[joint][2], 0, 1e-5f) << "joint " << joint;
}

TEST(StreetLiveGaze, OfBonesAloneEachEyeByItself) {
  LiveConnection live("vmc");
  live.Send(OscBundle({ToTheRight("LeftEye"), Down("RightEye"), VmcApply()}));
  ASSERT_TRUE(live.Poll());
  ExpectTurn(live.frame, 3, 0, -0.2f);
  ExpectTurn(live.frame, 4, 0.2f, 0);
  // To the same side as by scores.
  live.Send(OscBundle({VmcValue("eyeLookInLeft", 0.5f), VmcApply()}));
  ASSERT_TRUE(live.Poll(1));
  ExpectTurn(live.frame, 3, 0, -0.2f);
  EXPECT_EQ(live.Notes(), "");
}

TEST(StreetLiveGaze, BonesInAnySpelling) {
  for (const char* name : {"leftEye", "lefteye", "LEFTEYE", "Left_Eye", "Eye_L", "eyeLeft"}) {
    LiveConnection live("vmc");
    live.Send(OscBundle({ToTheRight(name), VmcApply()}));
    ASSERT_TRUE(live.Poll());
    ExpectTurn(live.frame, 3, 0, -0.2f);
    ExpectTurn(live.frame, 4, 0, 0);
  }
}

TEST(StreetLiveGaze, BonesThatNeverTurnCancelNoScores) {
  LiveConnection live("vmc");
  live.Send(OscBundle({Straight("LeftEye"),
                       Straight("RightEye"),
                       VmcValue("eyeLookUpLeft", 1),
                       VmcValue("eyeLookOutRight", 1),
                       VmcApply()}));
  ASSERT_TRUE(live.Poll());
  ExpectTurn(live.frame, 3, -0.3f, 0);
  ExpectTurn(live.frame, 4, 0, -0.4f);
}

TEST(StreetLiveGaze, ScoresThatAreAlwaysZeroCancelNoBones) {
  LiveConnection live("vmc");
  live.Send(OscBundle({VmcValue("eyeLookUpLeft", 0),
                       VmcValue("eyeLookOutRight", 0),
                       ToTheRight("LeftEye"),
                       ToTheRight("RightEye"),
                       VmcApply()}));
  ASSERT_TRUE(live.Poll());
  ExpectTurn(live.frame, 3, 0, -0.2f);
  ExpectTurn(live.frame, 4, 0, -0.2f);
}

TEST(StreetLiveGaze, WhereBothMoveScoresCountAndForAWhileAfter) {
  LiveConnection live("vmc");
  const auto send = [&](float up, int64_t now_ns) {
    live.Send(OscBundle({VmcValue("eyeLookUpLeft", up), ToTheRight("LeftEye"), VmcApply()}));
    ASSERT_TRUE(live.Poll(now_ns));
  };
  send(1, 0);
  ExpectTurn(live.frame, 3, -0.3f, 0);
  send(0, kSecond);  // straight ahead: not at once elsewhere
  ExpectTurn(live.frame, 3, 0, 0);
  send(0, 3 * kSecond);  // the tracker has changed
  ExpectTurn(live.frame, 3, 0, -0.2f);
}

TEST(StreetLiveApply, WithoutItABundleIsAFrame) {
  LiveConnection live("vmc");
  live.Send(OscBundle({VmcValue("jawOpen", 0.5f), Down("Head")}));
  ASSERT_TRUE(live.Poll());
  EXPECT_FLOAT_EQ(live.JawOpen(), 0.5f);
  ExpectTurn(live.frame, 1, 0.2f, 0);
  EXPECT_FALSE(live.Poll(1));
  for (const float jaw : {0.25f, 0.75f}) live.Send(OscBundle({VmcValue("jawOpen", jaw)}));
  ASSERT_TRUE(live.Poll(2));
  EXPECT_FLOAT_EQ(live.JawOpen(), 0.75f);
  EXPECT_EQ(live.Counts().replaced, 1u);
  live.Send(OscBundle({OscBundle({VmcValue("jawOpen", 1)})}));
  ASSERT_TRUE(live.Poll(3));
  EXPECT_FLOAT_EQ(live.JawOpen(), 1);
}

TEST(StreetLiveApply, WithoutItSingleMessagesAreTakenAsTheyCome) {
  LiveConnection live("vmc");
  live.Send(VmcValue("jawOpen", 0.5f));
  live.Send(Down("Head"));
  ASSERT_TRUE(live.Poll());
  EXPECT_FLOAT_EQ(live.JawOpen(), 0.5f);
  ExpectTurn(live.frame, 1, 0.2f, 0);
  EXPECT_EQ(live.Counts().frames, 1u);
  EXPECT_EQ(live.Counts().packets, 2u);
}

TEST(StreetLiveApply, ASenderThatStopsSendingItIsNotWaitedForLong) {
  LiveConnection live("vmc");
  live.Send(OscBundle({VmcValue("jawOpen", 0.5f), VmcApply()}));
  ASSERT_TRUE(live.Poll());
  live.Send(OscBundle({VmcValue("jawOpen", 1)}));
  EXPECT_FALSE(live.Poll(kSecond / 10));
  ASSERT_TRUE(live.Poll(kSecond));
  EXPECT_FLOAT_EQ(live.JawOpen(), 1);
}

TEST(StreetLiveOsc, PlainAddresses) {
  for (const char* address :
       {"/jawOpen", "/JawOpen", "/avatar/parameters/JawOpen", "/face/jaw_open"}) {
    LiveConnection live("vmc");
    live.Send(OscText(address) + OscText(",f") + OscFloat(0.5f));
    ASSERT_TRUE(live.Poll()) << address;
    EXPECT_FLOAT_EQ(live.JawOpen(), 0.5f) << address;
    live.Send(OscText(address) + OscText(",") + OscText(address));  // without its value
    EXPECT_FALSE(live.Poll(1));
    EXPECT_NE(live.Notes().find("dropped: " + std::string(address) + " (1)"), std::string::npos)
        << live.Notes();
  }
}

TEST(StreetLiveOsc, OtherTypesAndCases) {
  const std::string value = OscText("/VMC/Ext/Blend/Val"), name = OscText("jawOpen");
  const std::string packets[] = {
      value + OscText(",si") + name + OscWord(1),
      value + OscText(",sd") + name + OscWord(0x3ff00000) + OscWord(0),
      value + OscText(",sT") + name,
      value + OscText(",bf") + OscWord(7) + name + OscFloat(1),
      value + OscText(",Sfs") + name + OscFloat(1) + OscText("more"),
      value + OscText(",sf") + name + OscFloat(1) + std::string(4, '\0'),
      OscText("/vmc/ext/blend/val") + OscText(",sf") + name + OscFloat(1),
      OscBundle({OscBundle({OscBundle({VmcValue("jawOpen", 1)})})}) + std::string(3, '\0'),
  };
  for (const std::string& packet : packets) {
    LiveConnection live("vmc");
    live.Send(packet);
    ASSERT_TRUE(live.Poll()) << testing::PrintToString(packet) << live.Counts().last_problem;
    EXPECT_FLOAT_EQ(live.JawOpen(), 1);
  }
}

TEST(StreetLiveBad, OneMessageFreezesNoFace) {
  const std::string value = OscText("/VMC/Ext/Blend/Val");
  const struct {
    std::string packet, dropped;
  } cases[] = {
      {VmcBone("Head", {0, 0, 0, 0}), "/VMC/Ext/Bone/Pos Head"},
      {VmcBone("LeftEye", {0, kNan, 0, 1}), "/VMC/Ext/Bone/Pos LeftEye"},
      {value + OscText(",s") + OscText("jawOpen"), "/VMC/Ext/Blend/Val jawOpen"},
      {VmcValue("jawOpen", kNan), "/VMC/Ext/Blend/Val jawOpen"},
      {VmcValue("jawOpen", 37), "/VMC/Ext/Blend/Val jawOpen"},  // percent
      {VmcValue("jawOpen", -4.28e8f), "/VMC/Ext/Blend/Val jawOpen"},
      {value + OscText(",sq") + OscText("jawOpen") + OscWord(0), "/VMC/Ext/Blend/Val jawOpen"},
      {value + OscText(",sf") + OscText("jawOpen"), "/VMC/Ext/Blend/Val jawOpen"},
      {OscText("/x") + OscText("," + std::string(40, 'T')), "/x"},
      {"abcd", "what is no OSC message"},
  };
  for (const auto& c : cases) {
    LiveConnection live("vmc");
    for (int i = 1; i <= 3; ++i) {
      const float jaw = 0.25f * float(i);
      live.Send(OscBundle({VmcValue("jawOpen", jaw), c.packet, Down("Neck"), VmcApply()}));
      ASSERT_TRUE(live.Poll(i)) << c.dropped;
      EXPECT_FLOAT_EQ(live.JawOpen(), jaw);
      ExpectTurn(live.frame, 0, 0.2f, 0);
      ExpectTurn(live.frame, 1, 0, 0);
    }
    EXPECT_EQ(live.Counts().malformed, 3u);
    EXPECT_EQ(live.Counts().unused.dropped.Of(c.dropped), 3u) << live.Notes();
    EXPECT_NE(live.Notes().find("dropped: " + c.dropped + " (3)"), std::string::npos);
    EXPECT_NE(live.Counts().last_problem, "");
  }
}

TEST(StreetLiveBad, BonesOfTheBodyAreNotLookedAt) {
  LiveConnection live("vmc");
  live.Send(OscBundle({VmcBone("Hips", {0, 0, 0, 0}),
                       VmcBone("", {0, 0, 0, 1}),
                       VmcBone("Spine", {kNan, 0, 0, 1}),
                       VmcValue("jawOpen", 1),
                       VmcApply()}));
  ASSERT_TRUE(live.Poll());
  EXPECT_EQ(live.Counts().malformed, 0u);
  EXPECT_EQ(live.Notes(), "ignored bones:  (1), Hips (1), Spine (1)");
}

TEST(StreetLiveBad, OfACutBundleTheWholeMessagesAreTaken) {
  LiveConnection live("vmc");
  const std::string bundle = OscBundle({VmcValue("jawOpen", 0.5f), VmcValue("jawLeft", 1)});
  live.Send(bundle.substr(0, bundle.size() - 6));
  ASSERT_TRUE(live.Poll());
  EXPECT_FLOAT_EQ(live.JawOpen(), 0.5f);
  EXPECT_EQ(live.frame.params.pose[2][1], 0);
  EXPECT_EQ(live.Counts().malformed, 1u);
}

TEST(StreetLiveBad, OneScoreOfJsonFreezesNoFace) {
  LiveConnection live("udp");
  live.Send(R"({"seq": 1, "blendshapes": {"jawOpen": 0.5, "jawLeft": null, "jawRight": 40}})");
  ASSERT_TRUE(live.Poll());
  EXPECT_FLOAT_EQ(live.JawOpen(), 0.5f);
  EXPECT_EQ(live.frame.params.pose[2][1], 0);
  EXPECT_EQ(live.Counts().malformed, 2u);
  EXPECT_EQ(live.Notes(), "dropped: jawLeft (1), jawRight (1)");
}

}  // namespace
}  // namespace cosplat
