#include "splat/base/error.h"

#include <gtest/gtest.h>

namespace cosplat {
namespace {

TEST(Error, NamesFileFieldAndProblem) {
  EXPECT_STREQ(Error("a.npz", "x", "is 1, expected 2").what(), "a.npz: x: is 1, expected 2");
  EXPECT_STREQ(Error("", "x", "is missing").what(), "x: is missing");
  EXPECT_STREQ(Error("a.npz", "is missing").what(), "a.npz: is missing");
}

// Found by fuzzing: the type of an array, the name of a member, of a chunk of a PNG, of a field of
// a checkpoint.
TEST(Error, IsOneLineWhateverAFileHolds) {
  EXPECT_STREQ(Error("a\nb.npz", "x\x1b[2J", std::string("is '\0\x7f\r'", 8)).what(),
               "a\\x0ab.npz: x\\x1b[2J: is '\\x00\\x7f\\x0d'");
  EXPECT_STREQ(Error("\xc3\xa4.npz", "is missing").what(), "\xc3\xa4.npz: is missing");
}

TEST(Error, HasAnEnd) {
  const std::string text = Error("a.npz", std::string(100'000, 'x')).what();
  EXPECT_LT(text.size(), 1000u);
  EXPECT_TRUE(text.ends_with("x..."));
}

}  // namespace
}  // namespace cosplat
