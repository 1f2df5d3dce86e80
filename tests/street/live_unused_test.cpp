// Whoever wonders why a face stands still is told by the counts: nothing comes, what comes means
// nothing here, or it is damaged.
#include <gtest/gtest.h>

#include <algorithm>

#include "apps/cosplat/run/verbose_source.h"
#include "tests/street/live_source.h"

namespace cosplat {
namespace {

using test::LiveConnection;
using test::OscBundle;
using test::OscFloat;
using test::OscText;
using test::VmcApply;
using test::VmcValue;

std::string Message(const std::string& address) {
  return OscText(address) + OscText(",f") + OscFloat(1);
}

TEST(StreetLiveUnused, SilenceUselessPacketsAndDamageDiffer) {
  LiveConnection live("vmc");
  EXPECT_FALSE(live.Poll());
  EXPECT_EQ(ToString(live.Counts()), "no packet has arrived");
  for (int i = 0; i < 27; ++i) live.Send(Message("/Foo/Bar"));
  live.Send(OscBundle({VmcValue("Joy", 1), VmcValue("Neutral", 0.5f)}));
  EXPECT_FALSE(live.Poll());
  LiveCounts counts = live.Counts();
  EXPECT_EQ(counts.packets, 28u);
  EXPECT_EQ(counts.unusable, 28u);
  EXPECT_EQ(counts.malformed, 0u);
  EXPECT_EQ(live.Notes(),
            "ignored messages: /Foo/Bar (27); ignored blendshapes: Joy (1), Neutral (1)");
  live.Send("{\"seq\": 1}");  // the other protocol
  EXPECT_FALSE(live.Poll());
  counts = live.Counts();
  EXPECT_EQ(counts.packets, 29u);
  EXPECT_EQ(counts.unusable, 28u);
  EXPECT_EQ(counts.malformed, 1u);
  EXPECT_NE(live.Notes().find("dropped: what is no OSC message (1)"), std::string::npos);
  live.Send(VmcValue("jawOpen", 1));
  EXPECT_TRUE(live.Poll());
  EXPECT_EQ(live.Counts().unusable, 28u);
  EXPECT_EQ(ToString(live.Counts()).find("30 packets, 1 frames taken, 28 packets without anything"),
            0u)
      << ToString(live.Counts());
}

TEST(StreetLiveUnused, NamesOfJsonToo) {
  LiveConnection live("udp");
  for (int i = 0; i < 3; ++i)
    live.Send("{\"seq\": " + std::to_string(i) + ", \"blendshapes\": {\"Fcl_MTH_A\": 1}}");
  ASSERT_TRUE(live.Poll());
  EXPECT_EQ(live.Counts().packets, 3u);
  EXPECT_EQ(live.Notes(), "ignored blendshapes: Fcl_MTH_A (3)");
}

TEST(StreetLiveUnused, TheMapsOwnGapsAreOneLine) {
  LiveConnection live("vmc");
  for (const std::string_view name : kArkitNames) live.Send(VmcValue(std::string(name), 0.5f));
  ASSERT_TRUE(live.Poll());
  EXPECT_EQ(live.Notes(), "ignored blendshapes: those of ARKit that move nothing by this map (41)");
}

TEST(StreetLiveUnused, MemoryAndTextAreBounded) {
  LiveConnection live("vmc");
  const std::string evil = "/\x1b[2J\n\x07\xff\xc2\x9b" + std::string(300, 'x');
  for (int round = 0; round < 40; ++round) {
    for (int i = 0; i < 50; ++i) {
      const std::string number = std::to_string(50 * round + i);
      live.Send(
          OscBundle({Message(evil + number),
                     Message("/a/" + number),
                     VmcValue(evil + number, 1),
                     test::VmcBone(evil + number, {0, 0, 0, 1}),
                     OscText("/VMC/Ext/Blend/Val") + OscText(",s") + OscText(evil + number)}));
    }
    live.Poll(round);
  }
  const std::string notes = live.Notes(), problem = live.Counts().last_problem;
  EXPECT_LT(notes.size(), 8000u);
  EXPECT_LT(problem.size(), 400u);
  for (const std::string& text : {notes, problem})
    for (const char c : text) EXPECT_TRUE(c >= ' ' && c <= '~') << int(c);
  EXPECT_NE(notes.find("others ("), std::string::npos);
  EXPECT_EQ(live.Counts().packets, 2000u);
}

TEST(StreetLiveUnused, TwoSendersAtOnceAreSaid) {
  LiveConnection live("vmc");
  UdpSocket other = live.Sender();
  live.Send(VmcValue("jawOpen", 1));
  live.Poll();
  ASSERT_TRUE(other.Send(VmcValue("jawOpen", 0)));  // perhaps in its place
  live.Poll();
  EXPECT_EQ(live.Notes(), "");
  live.Send(VmcValue("jawOpen", 1));
  live.Poll();
  EXPECT_NE(live.Notes().find("two senders take turns: 127.0.0.1:"), std::string::npos);
  EXPECT_NE(live.Notes().find(other.LocalAddress()), std::string::npos) << live.Notes();
  EXPECT_NE(live.Notes().find(live.sender.LocalAddress()), std::string::npos) << live.Notes();
}

TEST(StreetLiveUnused, VerboseSaysItOnStandardError) {
  LiveConnection live("vmc");
  UdpSocket sender = live.Sender();
  testing::internal::CaptureStderr();
  {
    VerboseSource verbose(std::move(live.source));
    LiveFrame frame;
    for (int i = 0; i < 27; ++i) sender.Send(Message("/Foo/Bar"));
    for (const int64_t second : {0, 1, 2}) verbose.Poll(second * 1'000'000'000, frame);
    sender.Send(VmcValue("jawOpen", 1));
    EXPECT_TRUE(verbose.Poll(2'100'000'000, frame));
  }
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_NE(text.find("27 packets without anything usable"), std::string::npos) << text;
  EXPECT_NE(text.find("ignored messages: /Foo/Bar (27)"), std::string::npos);
  EXPECT_NE(text.find("28 packets, 1 frames taken"), std::string::npos);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << "not said again: " << text;
}

}  // namespace
}  // namespace cosplat
