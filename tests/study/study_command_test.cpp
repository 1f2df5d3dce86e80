// `cosplat-study` from end to end: a small list is run, cut short, gone on with and shown.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "splat/base/json.h"
#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

using Strings = std::vector<std::string>;

// Balls and a head, two seeds of the balls.
struct StudyFolder {
  TemporaryFolder folder;
  std::string list = folder / "list.json", data = folder / "data", out = folder / "out";
  CommandResult result;

  StudyFolder() { WriteBallScene(data + "/balls", 3); }
  void Write(int iterations) const {
    const Json balls{{"name", "balls"},
                     {"kind", "scene"},
                     {"source", "balls"},
                     {"arguments", {"--random-points", "200"}},
                     {"seeds", {0, 1}}};
    const Json head{{"name", "head"},
                    {"kind", "avatar"},
                    {"make_head", {"--frames", "6", "--test-frames", "2", "--size", "32"}},
                    {"arguments", {"--gaussians", "300"}}};
    const Strings all{"--eval", "--iterations", std::to_string(iterations)};
    const Json json{{"defaults", {{"arguments", all}, {"checkpoints", {10}}}},
                    {"data", {balls, head}},
                    {"runs",
                     {{{"name", "sh"}, {"arguments", {"--basis", "sh"}}, {"groups", {"bases"}}},
                      {{"name", "literal"},
                       {"arguments", {"--basis", "dcsh-literal", "--prune", "lightgaussian"}},
                       {"groups", {"bases"}},
                       {"minus", {"sh"}},
                       {"data", {"balls"}}}}}};
    std::ofstream(list) << json;
  }
  CommandResult Run(const Strings& more = {}, const std::string& before = "") const {
    Strings arguments{"--list", list, "--data", data, "-o", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Cosplat(arguments, before);
  }
  std::vector<Json> Lines() const {
    std::vector<Json> lines;
    std::ifstream stream(out + "/runs.jsonl");
    for (std::string line; std::getline(stream, line);) lines.push_back(Json::parse(line));
    return lines;
  }
  static const StudyFolder& Get() {
    static StudyFolder made;
    if (!fs::exists(made.list)) {
      made.Write(20);
      made.result = made.Run();
    }
    return made;
  }
};

const StudyFolder& Made() { return StudyFolder::Get(); }

bool Has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Study, RunsTheListAndSaysHowFarItIs) {
  EXPECT_EQ(Made().result.code, 0) << Made().result.err;
  EXPECT_EQ(Made().result.err, "");
  for (const std::string part : {"0 of 5 runs are done", "1/5 balls/sh/0", "5/5", " h left"})
    EXPECT_TRUE(Has(Made().result.out, part)) << Made().result.out;
  EXPECT_TRUE(fs::exists(Made().out + "/index.html"));
  EXPECT_TRUE(fs::exists(Made().out + "/head/model.npz"));
}

TEST(Study, ALineHoldsWhatWasMeasuredAndTheCommand) {
  const std::vector<Json> lines = Made().Lines();
  ASSERT_EQ(lines.size(), 5u);
  const Json& first = lines[0];
  EXPECT_EQ(first["data"], "balls");
  EXPECT_EQ(first["name"], "sh");
  EXPECT_EQ(first["seed"], 0);
  EXPECT_TRUE(Has(first["command"], "cosplat train-scene -s balls -m MODEL"));
  ASSERT_EQ(first["checkpoints"].size(), 2u);
  EXPECT_EQ(first["checkpoints"][0]["iterations"], 10);
  const Strings of_both{"PSNR",
                        "SSIM",
                        "gaussians",
                        "mean_degree",
                        "ply_mb",
                        "seconds",
                        "cpu_seconds",
                        "peak_mb",
                        "fps"};
  const std::map<size_t, Strings> own{{0, {"ply_psnr", "sog_mb", "sog_psnr", "sog_ssim"}},
                                      {2, {"glb_mb"}}};  // the balls and the head, as SH
  for (auto [i, keys] : own) {
    keys.insert(keys.end(), of_both.begin(), of_both.end());
    for (const std::string& key : keys)
      EXPECT_GT(lines[i]["checkpoints"][1].value(key, 0.0), 0) << lines[i]["data"] << key;
  }
}

// Nothing can be saved of the literal formula: it is measured all the same.
TEST(Study, ABasisWithoutFilesHasNoSpeedAndNoSize) {
  const Json line = Made().Lines()[1];
  EXPECT_EQ(line["name"], "literal");
  EXPECT_EQ(line["minus"], Json({"sh"}));
  const Json& last = line["checkpoints"].back();
  EXPECT_GT(last.value("PSNR", 0.0), 0);
  EXPECT_EQ(last.count("fps") + last.count("ply_mb") + last.count("sog_mb"), 0u);
  EXPECT_TRUE(Has(Slurp(Made().out + "/index.html"), ">literal − sh<"));
}

TEST(Study, RemovesTheModelsUnlessTheyAreToBeKept) {
  EXPECT_FALSE(fs::exists(Made().out + "/models/balls/sh/0"));
  const StudyFolder& made = Made();
  const std::string out = made.folder / "kept";
  const CommandResult result = Cosplat({"--list",
                                        made.list,
                                        "--data",
                                        made.data,
                                        "-o",
                                        out,
                                        "--only",
                                        "bases/balls/sh/1",
                                        "--keep",
                                        "--quiet"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out + result.err, "");
  EXPECT_TRUE(fs::exists(out + "/models/balls/sh/1/results.json"));
  EXPECT_FALSE(fs::exists(out + "/models/balls/sh/0"));
}

TEST(Study, GoesOnWhereItWasCutShort) {
  const StudyFolder& made = Made();
  EXPECT_TRUE(Has(made.Run().out, "5 of 5 runs are done"));
  const std::string file = made.out + "/runs.jsonl";
  const std::string whole = Slurp(file);
  fs::resize_file(file, whole.size() - 30);
  const CommandResult dry = made.Run({"--dry-run"});
  EXPECT_EQ(dry.code, 0) << dry.err;
  EXPECT_EQ(size_t(std::count(dry.out.begin(), dry.out.end(), '\n')), 5u);
  EXPECT_TRUE(Has(dry.out, "done balls/sh/0: cosplat train-scene"));
  EXPECT_TRUE(Has(dry.out, "todo balls/literal/1: cosplat train-scene"));
  const CommandResult result = made.Run();
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(Has(result.out, "4 of 5 runs are done")) << result.out;
  EXPECT_TRUE(Has(result.out, "1/1 balls/literal/1")) << result.out;
  const std::vector<Json> lines = made.Lines();
  ASSERT_EQ(lines.size(), 5u);
  const Json before = Json::parse(whole.substr(whole.rfind('\n', whole.size() - 2) + 1));
  EXPECT_EQ(lines[4]["checkpoints"][1]["PSNR"], before["checkpoints"][1]["PSNR"]);
}

// What Slurm does with an array job, one task after the other, by a stand-in for sbatch.
TEST(Study, SubmitsAnArrayJobWhoseLinesComeBackTogether) {
  const StudyFolder& made = Made();
  const std::string out = made.folder / "slurm_out", bin = made.folder / "bin";
  fs::create_directories(bin);
  std::ofstream(bin + "/sbatch") << "#!/bin/sh\n"
                                    "[ $# = 5 ] && [ \"$3\" = --partition=long ] || exit 3\n"
                                    "tasks=$(sed -n 's/^#SBATCH --array=1-//p' \"$5\")\n"
                                    "for i in $(seq $tasks); do\n"
                                    "  SLURM_ARRAY_TASK_ID=$i sh \"$5\" || exit 4\n"
                                    "done >\"$(dirname \"$5\")/tasks.log\" 2>&1\n"
                                    "echo 17\n";
  fs::permissions(bin + "/sbatch", fs::perms::owner_all);
  const auto submit = [&](const Strings& more) {
    Strings arguments{"--list", made.list, "--data", made.data, "-o", out, "--slurm"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Cosplat(arguments, "PATH=" + bin + ":$PATH");
  };
  const CommandResult job = submit({"--sbatch", "--partition=long --exclusive"});
  EXPECT_EQ(job.code, 0) << job.err << Slurp(out + "/slurm/tasks.log");
  EXPECT_TRUE(Has(job.out, "5 of 5 runs submitted as job 17")) << job.out;
  EXPECT_TRUE(fs::exists(out + "/head/model.npz")) << "made once, before its tasks";
  EXPECT_TRUE(fs::exists(out + "/run+balls+literal+1.jsonl"));
  EXPECT_FALSE(fs::exists(out + "/runs.jsonl"));
  EXPECT_TRUE(Has(submit({}).out, "all 5 runs are done"));
  EXPECT_EQ(Cosplat({"--page", "-o", out}).code, 0);
  EXPECT_TRUE(Has(Slurp(out + "/index.html"), ">literal − sh<"));
  std::ofstream(bin + "/sbatch") << "#!/bin/sh\necho 'error: Invalid partition' >&2; exit 1\n";
  fs::remove(out + "/run+balls+literal+1.jsonl");
  const CommandResult refused = submit({});
  EXPECT_EQ(refused.code, 2);
  EXPECT_TRUE(Has(refused.err, "sbatch: exited with status 1: error: Invalid partition"))
      << refused.err;
}

TEST(Study, WritesThePageAlone) {
  const StudyFolder& made = Made();
  const std::string charts = made.folder / "charts";
  const CommandResult result = Cosplat({"--page", "-o", made.out, "--charts", charts});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_TRUE(fs::exists(charts + "/balls-bases-psnr-gaussians.svg"));
  EXPECT_TRUE(fs::exists(charts + "/head-bases-psnr-glb-mb.svg"));
}

TEST(Study, GoesOnAfterARunThatFails) {
  const TemporaryFolder folder;
  const StudyFolder& made = Made();
  const Json list{{"data", {{{"name", "balls"}, {"kind", "scene"}, {"source", "balls"}}}},
                  {"runs",
                   {{{"name", "bad"}, {"arguments", {"--basis", "none"}}},
                    {{"name", "good"},
                     {"arguments", {"--eval", "--iterations", "5", "--random-points", "50"}}}}}};
  std::ofstream(folder / "list.json") << list;
  const CommandResult result =
      Cosplat({"--list", folder / "list.json", "--data", made.data, "-o", folder / "out"});
  EXPECT_EQ(result.code, 2);
  for (const std::string part :
       {"balls/bad/0", "--basis none", "failed with code 2", "1 of 2 runs failed"})
    EXPECT_TRUE(Has(result.err, part)) << result.err;
  const std::string lines = Slurp(folder / "out/runs.jsonl");
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 1);
  EXPECT_TRUE(Has(lines, "\"good\""));
}

TEST(Study, LeavesAFolderAloneThatItDidNotMake) {
  const TemporaryFolder folder;
  const Json list{{"data", {{{"name", "head"}, {"kind", "avatar"}, {"make_head", Json::array()}}}},
                  {"runs", {{{"name", "any"}}}}};
  std::ofstream(folder / "list.json") << list;
  const std::string notes = folder / "out/head/notes.txt";
  fs::create_directories(folder / "out/head");
  std::ofstream(notes) << "mine";
  const CommandResult result =
      Cosplat({"--list", folder / "list.json", "--data", "data", "-o", folder / "out"});
  EXPECT_EQ(result.code, 2);
  EXPECT_TRUE(Has(result.err, "head/any/0: " + (folder / "out/head"))) << result.err;
  EXPECT_EQ(Slurp(notes), "mine");
}

// While a run trains: as from a terminal, which reaches the run as well, and alone.
TEST(Study, StopsAtOnceWhenInterrupted) {
  for (const std::string whom : {"-$!", "$!"}) {
    const StudyFolder folder;
    folder.Write(10000000);
    const std::string begun = folder.out + "/models/balls/sh/0/run.json";
    const CommandResult result = folder.Run(
        {},
        "sh -c 'setsid \"$@\" & while [ ! -e " + begun +
            " ] && kill -0 $!; do sleep 0.05; done; kill -s TERM -- " + whom + "; wait $!' sh");
    EXPECT_EQ(result.code, 2);
    EXPECT_TRUE(Has(result.err, "the same command goes on from here")) << result.err;
    EXPECT_EQ(Slurp(folder.out + "/runs.jsonl"), "");
  }
}

// What a process holds that starts a run is not the run's.
TEST(Study, PeakMemoryIsTheRunsOwn) {
  const TemporaryFolder folder;
  const std::vector<char> held(size_t(700) << 20, 1);
  const CommandResult result = Cosplat({"train-scene",
                                        "-s",
                                        Made().data + "/balls",
                                        "-m",
                                        folder / "model",
                                        "--iterations",
                                        "2",
                                        "--random-points",
                                        "50",
                                        "--quiet"},
                                       "",
                                       COSPLAT_TRAINER);
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_LT(ReadJson(folder / "model/stats.json")["peak_mb"].get<double>(), 600);
  EXPECT_EQ(held.back(), 1);
}

void ExpectRefused(const Strings& arguments, const Strings& parts) {
  const CommandResult result = Cosplat(arguments);
  EXPECT_EQ(result.code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  for (const std::string& part : parts) EXPECT_TRUE(Has(result.err, part)) << result.err;
}

TEST(Study, RefusesBadInput) {
  const StudyFolder& made = Made();
  const std::string out = made.folder / "none", list = made.folder / "bad.json";
  ExpectRefused({"-o", out}, {"--list, --data"});
  ExpectRefused({"--page", "-o", out}, {out, "no finished run"});
  ExpectRefused({"--list", list, "--data", made.data, "-o", out}, {"bad.json"});
  ExpectRefused({"--list", made.list, "--data", made.data, "-o", out, "--only", "fish"},
                {"--only 'fish'", made.list});
  const std::string net = made.folder / "net";
  ExpectRefused({"--list", made.list, "--data", made.data, "-o", out, "--lpips", net}, {net});
  std::ofstream(list) << R"({"data": [{"name": "a", "kind": "scene"}], "runs": []})";
  ExpectRefused({"--list", list, "--data", made.data, "-o", out},
                {"bad.json", "data[0].source", "missing"});
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace cosplat::test
