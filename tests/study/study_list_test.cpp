// apps/study/runs/study_list.h: what a list is crossed to, and what is said of a bad one.
#include "apps/study/runs/study_list.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/study/good_study_list.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

using Strings = std::vector<std::string>;

class StudyListTest : public testing::Test {
 protected:
  std::string Write(const std::string& text) const {
    const std::string path = folder_ / "list.json";
    std::ofstream(path) << text;
    return path;
  }
  // `changed` in place of a part of a list that is good.
  void ExpectRefused(const std::string& part,
                     const std::string& changed,
                     const Strings& named) const {
    std::string text = kGood;
    const size_t at = text.find(part);
    ASSERT_NE(at, std::string::npos) << part;
    text.replace(at, part.size(), changed);
    ExpectError([&] { ReadStudyList(Write(text)); }, named);
  }

  static constexpr const char* kGood = test::kGoodStudyList;
  const TemporaryFolder folder_;
};

TEST_F(StudyListTest, CrossesSettingsDataAndSeeds) {
  Strings ids;
  for (const StudyRun& run : ReadStudyList(Write(kGood))) ids.push_back(run.Id());
  EXPECT_EQ(ids,
            (Strings{"fox/dcsh/0",
                     "fox/sh/0",
                     "fox/speedy-200/0",
                     "fox/speedy-100/0",
                     "head/dcsh/3",
                     "head/sh/3",
                     "head/lp-0.0005/3",
                     "head/lp-2/3",
                     "fox/dcsh/5",
                     "fox/sh/5"}));
}

TEST_F(StudyListTest, CommandsHoldOnAnyMachine) {
  const std::vector<StudyRun> runs = ReadStudyList(Write(kGood));
  EXPECT_EQ(runs[3].Command(),
            "cosplat train-scene -s 'a fox' -m MODEL --eval --prune-to 100 --seed 0 "
            "--test_iterations 10 --save_iterations 10");
  EXPECT_EQ(runs[6].Command(),
            "cosplat make-head -o head --size 64 && cosplat train-avatar -s head --flame "
            "head/model.npz -m MODEL --eval --prune-lambda 0.0005 --seed 3");
  EXPECT_EQ(runs[0].TrainArguments("data/", "out/", "m")[2], "data/a fox");
  EXPECT_EQ(runs[6].TrainArguments("data/", "out/", "m")[2], "out/head");
  EXPECT_EQ(runs[0].label, "DCSH");
  EXPECT_EQ(runs[0].groups, (Strings{"bases", "pruning"}));
  EXPECT_EQ(runs[1].label, "sh");
  EXPECT_EQ(runs[0].data.published.at("Others'").at("PSNR"), 31.5);
  EXPECT_TRUE(runs[6].data.published.empty());
}

// docs/study/insta.json: whoever has INSTA's subjects below one folder.
TEST(StudyLists, InstasSubjectsAreThere) {
  const std::vector<StudyRun> runs = ReadStudyList(COSPLAT_SOURCE_DIR "/docs/study/insta.json");
  ASSERT_EQ(runs.size(), 20u);
  EXPECT_EQ(runs[5].Command(),
            "cosplat train-avatar -s insta/justin --flame flame2023.pkl -m MODEL --eval "
            "--background black --quality best --seed 0");
  EXPECT_EQ(runs[5].data.published.at("FlashAvatar").at("PSNR"), 32.11);
}

TEST_F(StudyListTest, NamesWhatIsWrong) {
  const std::string file = folder_ / "list.json";
  ExpectRefused("\"label\"", "\"lable\"", {file, "runs[0].lable"});
  ExpectRefused("\"kind\": \"scene\"", "\"kind\": \"film\"", {file, "data[0].kind", "film"});
  ExpectRefused("\"source\": \"a fox\", ", "", {file, "data[0].source", "missing"});
  ExpectRefused(", \"counts\": [200, 100]", "", {file, "runs[2].arguments", "{count}", "fox"});
  ExpectRefused("\"values\": [5e-4, 2],", "", {file, "runs[3].values"});
  ExpectRefused("\"values\": [5e-4, 2]", "\"values\": [\"x\"]", {file, "runs[3].values[0]", "x"});
  ExpectRefused("{value}", "{count}", {file, "runs[3].arguments", "{count}", "values"});
  ExpectRefused("{value}", "0.1", {file, "runs[3].values", "{value}"});
  ExpectRefused("\"data\": [\"fox\"]", "\"data\": [\"dog\"]", {file, "runs[2].data", "dog"});
  ExpectRefused("\"seeds\": [0]", "\"seeds\": [3]", {file, "runs[2].seeds", "3"});
  ExpectRefused("\"minus\": [\"sh\"]", "\"minus\": [\"sch\"]", {file, "dcsh", "sch"});
  ExpectRefused("\"name\": \"sh\"", "\"name\": \"dcsh\"", {file, "two", "fox/dcsh/0"});
  ExpectRefused("\"name\": \"sh\"", "\"name\": \"../sh\"", {file, "runs[1].name", "../sh"});
  ExpectRefused("[0, 5]", "[0, -5]", {file, "defaults.seeds[1]", "-5"});
  ExpectRefused("[0, 5]", "[5, 5]", {file, "defaults.seeds[1]", "5", "already"});
  ExpectRefused("[0, 5]", "[0, 5", {file, "line 2"});
  ExpectRefused("\"make_head\"",
                "\"source\": \"a head\", \"make_head\"",
                {file, "data[1].make_head", "source"});
  ExpectRefused("\"source\": \"a fox\"",
                "\"source\": \"a fox\", \"make_head\": []",
                {file, "data[0].make_head", "scene"});
  ExpectRefused("\"PSNR\"", "\"PNSR\"", {file, "data[0].published.Others'.PNSR"});
  ExpectRefused("31.5", "\"31.5\"", {file, "data[0].published.Others'.PSNR", "31.5"});
  ExpectRefused("[\"--eval\"]", "\"--eval\"", {file, "defaults.arguments", "--eval"});
}

}  // namespace
}  // namespace cosplat::test
