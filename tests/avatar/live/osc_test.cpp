#include "avatar/live/osc.h"

#include <gtest/gtest.h>

#include "tests/avatar/live/osc_builder.h"

namespace cosplat {
namespace {

using test::OscBundle;
using test::OscFloat;
using test::OscText;
using test::OscWord;

// The packet must outlive its messages, which point into it.
std::vector<OscMessage> Parse(const std::string& packet) {
  std::vector<OscMessage> messages;
  ParseOsc(packet, messages);
  for (const OscMessage& message : messages) EXPECT_EQ(message.problem, "");
  return messages;
}

// The first.
std::string ProblemOf(const std::string& packet) {
  std::vector<OscMessage> messages;
  ParseOsc(packet, messages);
  for (const OscMessage& message : messages)
    if (!message.problem.empty()) return std::string(message.problem);
  return "";
}

TEST(Osc, EveryTypeOfArgument) {
  const std::string packet = OscText("/a") + OscText(",ifhdsSTFNI[b]tcrm") + OscWord(uint32_t(-7)) +
                             OscFloat(0.5f) + OscWord(0) + OscWord(9) + OscWord(0x3ff80000) +
                             OscWord(0) + OscText("four") + OscText("s") + OscWord(5) + "12345" +
                             std::string(3, '\0') + std::string(8, '\0') + OscWord('c') +
                             OscWord(1) + OscWord(2);
  const std::vector<OscMessage> messages = Parse(packet);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].address, "/a");
  const auto& arguments = messages[0].arguments;
  ASSERT_EQ(arguments.size(), 17u);
  const double numbers[] = {-7, 0.5, 9, 1.5};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(arguments[i].IsNumber());
    EXPECT_EQ(arguments[i].number, numbers[i]);
  }
  EXPECT_EQ(arguments[4].text, "four");
  EXPECT_EQ(arguments[5].text, "s");
  EXPECT_TRUE(arguments[5].IsText());
  EXPECT_EQ(arguments[6].number, 1);
  EXPECT_EQ(arguments[7].number, 0);
  EXPECT_FALSE(arguments[8].IsNumber());
}

TEST(Osc, MessagesOfBundlesInOrder) {
  const std::string a = OscText("/a") + OscText(",");
  const std::string no_types = OscText("/old");  // as senders before OSC 1.0 wrote them
  const std::string packet = OscBundle({a, OscBundle({no_types, a}), a});
  const std::vector<OscMessage> messages = Parse(packet);
  ASSERT_EQ(messages.size(), 4u);
  EXPECT_EQ(messages[1].address, "/old");
  EXPECT_TRUE(messages[1].arguments.empty());
  EXPECT_TRUE(Parse(OscBundle({})).empty());
}

TEST(Osc, NumbersThatAreNotFiniteAreNone) {
  const std::vector<OscMessage> messages =
      Parse(OscText("/a") + OscText(",ff") + OscWord(0x7fc00000) + OscWord(0x7f800000));
  EXPECT_FALSE(messages[0].arguments[0].IsNumber());
  EXPECT_FALSE(messages[0].arguments[1].IsNumber());
}

TEST(Osc, WhatIsWrongIsSaid) {
  const std::string a = OscText("/a");
  const struct {
    std::string packet, problem;
  } cases[] = {
      {"", "no OSC address"},
      {"/a", "no OSC address"},
      {OscText("a"), "no OSC address"},
      {a + OscText("f"), "no OSC type tags"},
      {a + "xxxx", "no OSC type tags"},
      {a + OscText(",q"), "unknown OSC type"},
      {a + OscText(",f"), "ends within"},
      {a + OscText(",s") + "abcd", "ends within"},
      {a + OscText(",b"), "ends within"},  // where liblo 0.31 reads on
      {a + OscText(",b") + OscWord(0xffffffff), "ends within"},
      {a + OscText(",b") + OscWord(5) + "1234", "ends within"},
      {a + OscText(",i") + OscWord(1) + OscWord(2), "longer than"},
      {a + OscText("," + std::string(kMaxOscArguments + 1, 'T')), "32 arguments"},
      {OscBundle({a}).substr(0, 12), "within an OSC bundle"},
      {OscBundle({a}) + "12", "within an OSC bundle"},
      {OscBundle({}) + OscWord(0x80000000), "within an OSC bundle"},
      {OscBundle({"abcd"}), "no OSC address"},
  };
  for (const auto& c : cases)
    EXPECT_NE(ProblemOf(c.packet).find(c.problem), std::string::npos) << ProblemOf(c.packet);
}

TEST(Osc, ABadElementCostsOnlyItself) {
  const std::string a = OscText("/a") + OscText(","), cut = OscText("/b") + OscText(",f");
  std::vector<OscMessage> messages;
  const std::string packet = OscBundle({a, cut, OscBundle({"abcd", a}), a}) + OscWord(99) + "/c";
  ParseOsc(packet, messages);
  ASSERT_EQ(messages.size(), 6u);
  const std::string_view addresses[] = {"/a", "/b", "", "/a", "/a", ""};
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(messages[i].address, addresses[i]);
    EXPECT_EQ(messages[i].problem.empty(), addresses[i] == "/a");
  }
}

TEST(Osc, ZerosAtTheEndArePadding) {
  const std::string a = OscText("/a") + OscText(",i") + OscWord(7);
  const std::string packet = OscBundle({a + std::string(8, '\0'), "", a}) + std::string(7, '\0');
  EXPECT_EQ(Parse(packet).size(), 2u);
}

TEST(Osc, ABlobIsTextUpToItsFirstZero) {
  const std::string packet =
      OscText("/a") + OscText(",b") + OscWord(6) + std::string("name\0x\0\0", 8);
  const std::vector<OscMessage> messages = Parse(packet);
  const OscArgument& argument = messages[0].arguments[0];
  EXPECT_TRUE(argument.IsText());
  EXPECT_EQ(argument.text, "name");
}

TEST(Osc, BundlesInsideEachOtherEnd) {
  std::string packet = OscText("/a");
  for (int i = 0; i < kMaxOscBundles; ++i) packet = OscBundle({packet});
  EXPECT_EQ(ProblemOf(packet), "");
  EXPECT_EQ(ProblemOf(OscBundle({packet})), "has OSC bundles nested too deeply");
}

}  // namespace
}  // namespace cosplat
