// `cosplat-study head-fit` as a user runs it.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

// Millimetres after this line's name.
double MillimetresOf(const std::string& text, const std::string& name) {
  std::smatch found;
  const bool is_there = std::regex_search(text, found, std::regex(name + R"( +([0-9.]+) mm)"));
  EXPECT_TRUE(is_there) << name << " in\n" << text;
  return is_there ? std::stod(found[1]) : NAN;
}

TEST(HeadFitCommand, OurHeadComesNearPeople) {
  const std::string people = COSPLAT_SOURCE_DIR "/../shared/data/flame/flame2023_open_noexpr.npz";
  if (!std::filesystem::exists(people)) GTEST_SKIP() << people << " is absent";
  const CommandResult result = Cosplat({"head-fit", people, "--count", "2"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_LT(MillimetresOf(result.out, "the mean face, by turn, shift and size"), 1.1);
  EXPECT_LT(MillimetresOf(result.out, "the mean face, with our shapes"), 1.0);
  const double placed = MillimetresOf(result.out, "2 people, by turn, shift and size");
  EXPECT_LT(MillimetresOf(result.out, "2 people, with our shapes"), 0.8 * placed);
}

TEST(HeadFitCommand, NamesAFileThatIsMissing) {
  const TemporaryFolder folder;
  const CommandResult result = Cosplat({"head-fit", folder / "none.npz"});
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("none.npz"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace cosplat::test
