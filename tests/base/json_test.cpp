#include "splat/base/json.h"

#include <gtest/gtest.h>

#include <cmath>

#include "splat/base/files.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

const JsonField Field(const Json& value) { return {"f.json", value}; }

TEST(Json, ReadsAFileAndItsFields) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "f.json",
                      R"({"a": {"b": [1, 2.5, {"c": "text"}]}, "m": [[1, 2], [3, 4]], "w": 8.0})");
  const Json json = ReadJson(folder / "f.json");
  const JsonField file(folder / "f.json", json);
  EXPECT_EQ(file["a"]["b"].size(), 3u);
  EXPECT_EQ(file["a"]["b"][1].Number(), 2.5);
  EXPECT_EQ(file["a"]["b"][2]["c"].String(), "text");
  EXPECT_EQ(file["m"].Numbers(4), (std::vector<float>{1, 2, 3, 4}));
  EXPECT_EQ(file["w"].Integer(), 8);
  EXPECT_EQ(file.NumberOr("w", 1), 8);
  EXPECT_EQ(file.NumberOr("h", 1), 1);
  EXPECT_TRUE(file.Has("a"));
  EXPECT_FALSE(file["m"].Has("a"));
}

// Python writes these three words; a string or key that holds them is left alone.
TEST(Json, NonFiniteNumbersBecomeNull) {
  const TemporaryFolder folder;
  WriteFileAtomically(
      folder / "f.json",
      "{\"NaN\": \"is \\\"Infinity\\\", NaN\", \"x\": [NaN, -Infinity, Infinity, 1]}");
  const Json json = ReadJson(folder / "f.json");
  const JsonField file(folder / "f.json", json);
  EXPECT_EQ(file["NaN"].String(), "is \"Infinity\", NaN");
  ExpectError([&] { file["x"].Numbers(); }, {"f.json", "x[0]", "null", "finite number"});
  const std::vector<double> numbers = file["x"].NumbersOrNan(4);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(std::isnan(numbers[i]));
  EXPECT_EQ(numbers[3], 1);
}

TEST(Json, SyntaxErrorsHaveLineAndColumn) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "f.json", "{\n  \"a\": 1,\n  \"b\": oops\n}");
  ExpectError([&] { ReadJson(folder / "f.json"); },
              {"f.json", "line 3, column 8", "not valid JSON"});
  WriteFileAtomically(folder / "cut.json", "{\"a\": [1, 2");
  ExpectError([&] { ReadJson(folder / "cut.json"); }, {"cut.json", "line 1", "ends too early"});
  WriteFileAtomically(folder / "empty.json", "");
  ExpectError([&] { ReadJson(folder / "empty.json"); }, {"empty.json", "ends too early"});
  WriteFileAtomically(folder / "huge.json", "[1e999]");
  ExpectError([&] { ReadJson(folder / "huge.json"); }, {"huge.json", "not valid JSON"});
  ExpectError([&] { ReadJson(folder / "none.json"); }, {"none.json", "No such file"});
}

TEST(Json, WrongTypesNameFieldAndValue) {
  const Json json = {{"a", {{"b", {1, "two"}}}}, {"n", 1.5}, {"big", 1e300}};
  const JsonField file = Field(json);
  ExpectError([&] { file["a"]["c"]; }, {"f.json", "a.c", "is missing"});
  ExpectError([&] { file["a"]["b"][1].Number(); }, {"a.b[1]", "\"two\"", "a finite number"});
  ExpectError([&] { file["a"]["b"][2]; }, {"a.b[2]", "is missing", "2"});
  ExpectError([&] { file["a"]["b"].Numbers(2); }, {"a.b[1]", "\"two\""});
  ExpectError([&] { file["a"].size(); }, {"a", "an object", "expected an array"});
  ExpectError([&] { file["n"]["x"]; }, {"n", "1.5", "an object with x"});
  ExpectError([&] { file["n"].Integer(); }, {"n", "1.5", "an integer"});
  ExpectError([&] { file["n"].String(); }, {"n", "1.5", "a string"});
  ExpectError([&] { file["n"].Numbers(); }, {"n", "1.5", "an array"});
  const Json numbers = {1, 2, 3};
  ExpectError([&] { Field(numbers).Numbers(4); }, {"3 numbers, expected 4"});
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "deep.json", std::string(200000, '[') + std::string(200000, ']'));
  const Json deep = ReadJson(folder / "deep.json");
  ExpectError([&] { Field(deep).Numbers(); }, {"[0][0][0][0]", "an array of 1", "finite number"});
  const Json large = {1e300};
  ExpectError([&] { Field(large).Numbers(); }, {"too large"});
  ExpectError([&] { file["big"].Integer(); }, {"big", "an integer"});
}

}  // namespace
}  // namespace cosplat
