#include "avatar/live/json_frame.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using test::ExpectError;

JsonFrame Parse(const std::string& line) { return ParseJsonFrame("here", line); }

TEST(JsonFrame, EveryField) {
  const JsonFrame frame = Parse(R"({"seq": 18446744073709551615, "time": 1.5, "expression": [1, 2],
      "pose": [0.1, 0.2, 0.3], "neck": [0.4, 0, 0], "jaw": [0.5, 0, 0],
      "eyes": [0.6, 0, 0, 0.7, 0, 0], "translation": [0, 0, -1e2]})");
  EXPECT_EQ(frame.sequence, std::numeric_limits<uint64_t>::max());
  EXPECT_EQ(frame.time, 1.5);
  EXPECT_EQ(frame.params.expression, (std::vector<float>{1, 2}));
  EXPECT_EQ(frame.params.pose[0], (std::array<float, 3>{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(frame.params.pose[1][0], 0.4f);
  EXPECT_EQ(frame.params.pose[2][0], 0.5f);
  EXPECT_EQ(frame.params.pose[3][0], 0.6f);
  EXPECT_EQ(frame.params.pose[4][0], 0.7f);
  EXPECT_EQ(frame.params.translation[2], -1e2f);
}

TEST(JsonFrame, WhatIsNotThereIsZero) {
  const JsonFrame frame = Parse(R"({"seq": 3, "eyes": [0.1, 0.2, 0.3]})");
  EXPECT_FALSE(frame.time);
  EXPECT_TRUE(frame.params.expression.empty());
  EXPECT_EQ(frame.params.pose[2], (std::array<float, 3>{}));
  EXPECT_EQ(frame.params.pose[3], (std::array<float, 3>{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(frame.params.pose[4], frame.params.pose[3]);
}

TEST(JsonFrame, WhatIsWrittenIsReadToTheBit) {
  JsonFrame frame;
  frame.sequence = 12;
  frame.time = 1764000000.123;
  frame.params.expression = {1.0f / 3, -1e-30f, 0};
  for (size_t j = 0; j < frame.params.pose.size(); ++j)
    frame.params.pose[j] = {0.1f * float(j), -1.0f / 7, 0};
  frame.params.translation = {0.01f, 0, 3};
  const std::string line = WriteJsonFrame(frame);
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const JsonFrame read = Parse(line);
  EXPECT_EQ(read.sequence, frame.sequence);
  EXPECT_EQ(read.time, frame.time);
  EXPECT_EQ(read.params.expression, frame.params.expression);
  EXPECT_EQ(read.params.pose, frame.params.pose);
  EXPECT_EQ(read.params.translation, frame.params.translation);
}

TEST(JsonFrame, BlendshapesStandForExpressionJawAndEyes) {
  JsonFrame frame;
  frame.params.pose[1] = {0, 0.1f, 0};
  frame.blendshapes = {{"jawOpen", 1.0f / 3}, {"eyeBlinkLeft", 0.0f}};
  const std::string line = WriteJsonFrame(frame);
  EXPECT_EQ(line.find("expression"), std::string::npos);
  const JsonFrame read = Parse(line);
  EXPECT_EQ(read.blendshapes, frame.blendshapes);
  EXPECT_EQ(read.params.pose, frame.params.pose);
  EXPECT_FALSE(Parse(R"({"seq": 1})").blendshapes);
  EXPECT_TRUE(Parse(R"({"seq": 1, "blendshapes": {}})").blendshapes);
}

TEST(JsonFrame, ABadScoreCostsOnlyItself) {
  const JsonFrame frame = Parse(R"({"seq": 1, "blendshapes": {"jawOpen": 0.5, "a": NaN, "b": null,
      "c": "0.5", "d": 37, "e": -3, "f": [1], "g": 1e300, "h": 1.25}})");
  EXPECT_EQ(frame.blendshapes, (BlendshapeScores{{"jawOpen", 0.5f}, {"h", 1.25f}}));
  EXPECT_EQ(frame.dropped, (std::vector<std::string>{"a", "b", "c", "d", "e", "f", "g"}));
}

TEST(JsonFrame, ErrorsNameTheField) {
  const struct {
    std::string line;
    std::vector<std::string> parts;
  } cases[] = {
      {"", {"not valid JSON", "too early"}},
      {"{\"seq\": 1", {"not valid JSON", "column"}},
      {"17", {"expected an object"}},
      {"{}", {"seq", "is missing"}},
      {R"({"seq": -1})", {"seq", "non-negative integer"}},
      {R"({"seq": 1.5})", {"seq", "non-negative integer"}},
      {R"({"seq": "1"})", {"seq", "non-negative integer"}},
      {R"({"seq": 1, "time": "now"})", {"time", "now"}},
      {R"({"seq": 1, "time": 1e300})", {"time", "9e9"}},
      {R"({"seq": 1, "jaw": [0, 0]})", {"jaw", "2 numbers", "expected 3"}},
      {R"({"seq": 1, "jaw": 0})", {"jaw", "expected an array"}},
      {R"({"seq": 1, "eyes": [0, 0, 0, 0]})", {"eyes", "4 numbers", "expected 6"}},
      {R"({"seq": 1, "expression": [0, NaN]})", {"expression[1]", "finite"}},
      {R"({"seq": 1, "expression": [0, 1e39]})", {"expression", "too large"}},
      {R"({"seq": 1, "expression": [0, 1e999]})", {"not valid JSON", "1e999"}},
      {R"({"seq": 1, "expression": [0, -101]})", {"expression[1]", "-101"}},
      {R"({"seq": 1, "expresion": [0]})", {"expresion", "not a field"}},
      {R"({"seq": 1, "blendshapes": [0.5]})", {"blendshapes", "not an object"}},
      {R"({"seq": 1, "blendshapes": {}, "jaw": [0, 0, 0]})", {"jaw", "beside blendshapes"}},
      {"{\"seq\": 1, \"a\\nb\": 0}", {"a\\nb", "not a field"}},
      {"{\"seq\": 1, \"" + std::string(5000, 'x') + "\": 0}", {"xxx", "..."}},
      {std::string(15000, '['), {"more than 64 arrays"}},
      {"{\"seq\": 1, \"jaw\": " + std::string(60, '[') + std::string(60, ']') + "}",
       {"jaw", "array"}},
  };
  for (const auto& c : cases) {
    std::vector<std::string> parts = c.parts;
    parts.push_back("here");
    ExpectError([&] { Parse(c.line); }, parts);
    try {
      Parse(c.line);
    } catch (const Error& error) {
      EXPECT_LT(std::string(error.what()).size(), 300u);
    }
  }
}

}  // namespace
}  // namespace cosplat
