// Every file that a command writes, on a disk that fails (tests/faults/faults.cpp), and too little
// memory: one line says what is wrong, no file is left half-written, no result of an earlier run is
// lost, and a training goes on from its checkpoint to the same bytes.
//
// Prints what was injected, where, and what came out; with COSPLAT_ALL_FAULTS=1, which takes some
// minutes, all rows of what docs/faults.md sums up.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>

#include "tests/integration/background_command.h"
#include "tests/integration/run_files.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

constexpr double kPatience = 300;  // seconds

// A command that writes into a folder `out`.
struct Writer {
  std::string name;
  std::function<std::vector<std::string>(const std::string& out)> arguments;
  std::string start = "";  // a folder that `out` is a copy of before; empty: it is not there
  bool resumes = false;    // an interrupted training
  std::string data = "";   // the folder that it reads
};

struct Outcome {
  int code;
  std::string said;  // on both streams
};

// "image_3.png.tmp.123" -> "image_N.png": one of each kind of file is enough.
std::string KindOf(std::string file) {
  const size_t temporary = file.find(".tmp.");
  if (temporary != std::string::npos) {
    const size_t dot = file.find('.', temporary + 5);
    const std::string end = dot == std::string::npos ? "" : file.substr(dot);
    file = file.substr(0, temporary) + end.substr(0, end.find('.', 1));  // libzip adds a third
  }
  const std::string end = fs::path(file).extension().string();
  std::string kind;
  for (const char c : file.substr(0, file.size() - end.size()))
    if (!isdigit(c))
      kind += c;
    else if (kind.empty() || kind.back() != 'N')
      kind += 'N';
  return kind + end;
}

class Faults : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string out_ = folder_ / "out", log_ = folder_ / "log";
  std::map<std::string, std::string> whole_, before_;
  std::map<std::string, std::string> shown_;  // files in the table

  Outcome Run(const Writer& writer, const std::vector<std::string>& environment) {
    std::vector<std::string> variables = environment;
    variables.push_back("LD_PRELOAD=" COSPLAT_FAULTS);
    BackgroundCommand run(writer.arguments(out_), log_, variables);
    EXPECT_TRUE(run.EndsWithin(kPatience)) << writer.name;
    return {run.status(), Slurp(log_)};
  }

  void Prepare(const Writer& writer) {
    fs::remove_all(out_);
    fs::create_directories(out_);
    if (!writer.start.empty()) fs::copy(writer.start, out_, fs::copy_options::recursive);
  }

  // An undisturbed run: the first file of each kind that it opens, under `below`.
  std::vector<std::string> Opened(const Writer& writer,
                                  const std::string& what,
                                  const std::string& below) {
    Prepare(writer);
    before_ = FilesOf(out_);
    const std::string list = folder_ / "opened";
    fs::remove(list);
    const Outcome outcome = Run(writer, {"COSPLAT_FAULT_LOG=" + list});
    EXPECT_EQ(outcome.code, 0) << writer.name << ": " << outcome.said;
    whole_ = FilesOf(out_);
    std::vector<std::string> files;
    std::set<std::string> kinds;
    std::ifstream lines(list);
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with(what + " " + below)) continue;
      const std::string file = line.substr(what.size() + 1 + below.size());
      if (!kinds.insert(KindOf(file)).second) continue;
      const std::string name = file.substr(0, file.find(".tmp."));
      const bool ends = fs::path(name).has_extension() || name == "/cfg_args";
      files.push_back(below + name + (ends ? "" : ".tmp."));  // not of all that begin like it
      shown_[files.back()] = KindOf(file.substr(file.find_first_not_of('/')));
    }
    return files;
  }

  // Files are as before or as the undisturbed run leaves them.
  void ExpectNoHalves(const std::string& of) {
    for (const auto& [name, bytes] : FilesOf(out_)) {
      if (name == "checkpoint.bin") continue;  // resuming shows whether it is whole
      const auto whole = whole_.find(name), before = before_.find(name);
      const bool known = (whole != whole_.end() && whole->second == bytes) ||
                         (before != before_.end() && before->second == bytes);
      EXPECT_TRUE(known) << of << ": " << name << " is neither whole nor as it was";
    }
  }

  void ExpectGoesOn(const Writer& writer, const std::string& of) {
    if (!writer.resumes) return;
    EXPECT_TRUE(fs::exists(out_ + "/checkpoint.bin")) << of;
    const Outcome outcome = Run(writer, {});
    EXPECT_EQ(outcome.code, 0) << of << ": " << outcome.said;
    ExpectSameFiles(whole_, FilesOf(out_), of + ", resumed");
  }

  // Neither the folders of this test nor numbers that change.
  std::string Shown(std::string said) const {
    for (const std::string& path : {out_ + "/", Workshop::Get().folder.path() + "/", folder_ / ""})
      for (size_t at; (at = said.find(path)) != std::string::npos;) said.erase(at, path.size());
    while (!said.empty() && said.back() == '\n') said.pop_back();
    return said;
  }

  // Rows that differ by the fault alone become one.
  void Row(const Writer& writer,
           const std::string& fault,
           const std::string& file,
           const Outcome& outcome) {
    std::string said = Shown(outcome.said);
    if (outcome.code == 0 && !said.starts_with("cosplat: "))
      said = fs::exists(out_ + "/skipped_frames.json")
                 ? "the frame is left out and listed in `skipped_frames.json`"
                 : "as without the fault";
    else
      said = "`" + said.substr(0, said.find('\n')) + "`";
    const auto shown = shown_.find(file);
    const std::string name = shown == shown_.end() ? file : shown->second;
    // "stats.json: write failed: REASON": the reason goes with the fault.
    const size_t reason = said.rfind(": ");
    const bool has_reason = said.starts_with("`cosplat") && reason > 9;
    const std::string outcome_text = has_reason ? said.substr(0, reason) + ": …`" : said;
    const std::string why =
        has_reason ? fault + " (" + said.substr(reason + 2, said.size() - reason - 3) + ")" : fault;
    const std::string row = "| `" + writer.name + "` | `" + name + "` | ";
    const std::string end = " | " + std::to_string(outcome.code) + " | " + outcome_text + " |";
    if (row == row_ && end == end_) {
      faults_ += ", " + why;
      return;
    }
    Flush();
    row_ = row, end_ = end, faults_ = why;
  }
  // With all faults alone: a failure would be hard to find among the rows.
  void Flush() {
    if (!row_.empty() && std::getenv("COSPLAT_ALL_FAULTS"))
      std::printf("%s%s%s\n", row_.c_str(), faults_.c_str(), end_.c_str());
    row_.clear();
  }
  void TearDown() override { Flush(); }

  std::string row_, faults_, end_;
  size_t files_failed_ = 0;

  // One line that names the file, or all is as without the fault.
  void Fail(const Writer& writer, const std::string& fault, const std::string& file) {
    const std::string of = writer.name + ", " + fault + ", " + file;
    Prepare(writer);
    const Outcome outcome = Run(writer, {"COSPLAT_FAULT=" + fault + ":" + file});
    Row(writer, fault, file, outcome);
    const bool checkpoint = file.ends_with("checkpoint.bin");
    const size_t lines = size_t(std::count(outcome.said.begin(), outcome.said.end(), '\n'));
    if (outcome.code == 0 && outcome.said.empty()) {
      ExpectSameFiles(whole_, FilesOf(out_), of);
      return;
    }
    EXPECT_TRUE(outcome.said.starts_with("cosplat: ")) << of << ": " << outcome.said;
    const std::string name = fs::path(file.substr(0, file.find(".tmp."))).stem().string();
    EXPECT_NE(outcome.said.find(name), std::string::npos) << of << ": " << outcome.said;
    // A checkpoint that cannot be written is a warning: training goes on.
    if (checkpoint && outcome.said.starts_with("cosplat: warning: no checkpoint")) {
      std::map<std::string, std::string> left = FilesOf(out_);
      left.erase("checkpoint.bin");
      ExpectSameFiles(whole_, left, of);
      // On a read-only disk it cannot be removed, either.
      EXPECT_EQ(outcome.code, fault == "readonly" ? 2 : 0) << outcome.said;
      return;
    }
    EXPECT_EQ(outcome.code, 2) << of << ": " << outcome.said;
    EXPECT_EQ(lines, 1u) << of << ": " << outcome.said;
    ExpectNoHalves(of);
    ExpectGoesOn(writer, of);
  }

  void FailEveryWrite(const Writer& writer) {
    const std::vector<std::string> files = Opened(writer, "write", out_);
    ASSERT_FALSE(files.empty()) << writer.name;
    for (const std::string& file : files) {
      // Two for each, in turn, since they take time.
      const bool all = std::getenv("COSPLAT_ALL_FAULTS"), even = ++files_failed_ % 2 == 0;
      if (all || even) Fail(writer, "full", file);
      if (all || !even) Fail(writer, "write-error", file);
      if (all || even) Fail(writer, "readonly", file);
      if (all || !even) Fail(writer, "vanish", file);
      if (file.ends_with("checkpoint.bin")) Fail(writer, "sync-error", file);
    }
    Prepare(writer);
    const Outcome pieces = Run(writer, {"COSPLAT_FAULT=short-write:" + out_});
    Row(writer, "short-write", "all files", pieces);
    EXPECT_EQ(pieces.code, 0) << pieces.said;
    ExpectSameFiles(whole_, FilesOf(out_), writer.name + ", short writes");
  }

  void FailEveryRead(const Writer& writer) {
    for (const std::string& file : Opened(writer, "read", writer.data)) {
      for (const char* fault : {"read-error", "vanish"}) FailRead(writer, fault, file);
    }
    Prepare(writer);
    const Outcome pieces = Run(writer, {"COSPLAT_FAULT=short-read:" + writer.data});
    Row(writer, "short-read", "all files", pieces);
    EXPECT_EQ(pieces.code, 0) << pieces.said;
    ExpectSameFiles(whole_, FilesOf(out_), writer.name + ", short reads");
  }

  // A frame that cannot be read is skipped; anything else is one line, and nothing is written.
  void FailRead(const Writer& writer, const std::string& fault, const std::string& file) {
    const std::string of = writer.name + ", " + fault + ", " + file;
    Prepare(writer);
    const Outcome outcome = Run(writer, {"COSPLAT_FAULT=" + fault + ":" + file});
    Row(writer, fault, file, outcome);
    if (outcome.code == 0) return;
    EXPECT_EQ(outcome.code, 2) << of << ": " << outcome.said;
    EXPECT_EQ(std::count(outcome.said.begin(), outcome.said.end(), '\n'), 1)
        << of << ": " << outcome.said;
    ExpectNoHalves(of);
  }

  Writer TrainScene() const {
    return {"train-scene",
            [](const std::string& out) {
              return MadeSceneTraining(out, 240, 300, {"--resume", "--quiet", "--budget", "auto"});
            },
            "",
            false,
            Workshop::Get().photos};
  }
  Writer TrainAvatar() const {
    const std::string landmarks = Workshop::Get().head + "/landmarks.json";
    return {
        "train-avatar",
        [landmarks](const std::string& out) {
          return MadeAvatarTraining(
              out, 90, 400, {"--resume", "--refine-track", "--landmarks", landmarks, "--quiet"});
        },
        "",
        false,
        Workshop::Get().head};
  }

  // The training as it was when a signal interrupted it. One that ended before the signal came,
  // since this process had to wait for the processor, is begun again.
  Writer Interrupted(Writer writer) {
    writer.start = folder_ / "interrupted";
    std::vector<std::string> arguments = writer.arguments(writer.start);
    arguments.insert(arguments.end(), {"--checkpoint-every", "0.0002"});
    int status = 0;
    for (int attempt = 0; status == 0 && attempt < 20; ++attempt) {
      fs::remove_all(writer.start);
      BackgroundCommand run(arguments, log_);
      while (!fs::exists(writer.start + "/checkpoint.bin"))
        if (run.EndsWithin(0.002)) break;
      run.Signal(SIGTERM);
      EXPECT_TRUE(run.EndsWithin(kPatience));
      status = run.status();
    }
    EXPECT_EQ(status, 128 + SIGTERM) << Slurp(log_);
    writer.name += " --resume";
    writer.resumes = true;
    return writer;
  }
};

TEST_F(Faults, TrainingAScene) { FailEveryWrite(Interrupted(TrainScene())); }
TEST_F(Faults, TrainingAnAvatar) { FailEveryWrite(Interrupted(TrainAvatar())); }
TEST_F(Faults, ReadingAScene) { FailEveryRead(TrainScene()); }
TEST_F(Faults, ReadingATrackedVideo) { FailEveryRead(TrainAvatar()); }

// A finished run, copied, since these write into it.
TEST_F(Faults, RenderingMeasuringAndReporting) {
  const std::string model = Workshop::Get().avatar;
  FailEveryWrite({"render",
                  [](const std::string& out) -> std::vector<std::string> {
                    return {"render", "-m", out, "--quiet"};
                  },
                  model});
  FailEveryWrite({"metrics",
                  [](const std::string& out) -> std::vector<std::string> {
                    return {"metrics", "-m", out};
                  },
                  model});
  FailEveryWrite({"report",
                  [](const std::string& out) -> std::vector<std::string> {
                    return {"report", "-m", out, "--quiet"};
                  },
                  model});
  FailEveryWrite({"render -o DIR", [model](const std::string& out) -> std::vector<std::string> {
                    return {"render", "-m", model, "--orbit", "-o", out, "--quiet"};
                  }});
  FailEveryWrite(
      {"render -o FILE.mp4", [model](const std::string& out) -> std::vector<std::string> {
         return {"render", "-m", model, "-o", out + "/video.mp4", "--quiet"};
       }});
}

TEST_F(Faults, ExportingSplats) {
  const std::string model = Workshop::Get().scene;
  FailEveryWrite({"export", [model](const std::string& out) -> std::vector<std::string> {
                    return {"export",
                            "-m",
                            model,
                            "--ply",
                            out + "/a.ply",
                            "--glb",
                            out + "/a.glb",
                            "--spz",
                            out + "/a.spz",
                            "--sog",
                            out + "/a.sog",
                            "--quiet"};
                  }});
}

TEST_F(Faults, MakingAndTrackingAHead) {
  FailEveryWrite({"make-head", [](const std::string& out) -> std::vector<std::string> {
                    return {"make-head",
                            "-o",
                            out,
                            "--frames",
                            "4",
                            "--test-frames",
                            "1",
                            "--size",
                            "32",
                            "--quiet"};
                  }});
  const std::string head = Workshop::Get().head;
  FailEveryWrite({"track", [head](const std::string& out) -> std::vector<std::string> {
                    return {"track",
                            head + "/image",
                            "--flame",
                            head + "/model.npz",
                            "--landmarks",
                            head + "/landmarks.json",
                            "--landmark-embedding",
                            head + "/landmark_embedding.npz",
                            "--avatar-rounds",
                            "0",
                            "-o",
                            out,
                            "--quiet"};
                  }});
}

// Too little address space (ulimit -v), from what the program needs to start up to what the run
// needs.
TEST_F(Faults, TooLittleMemory) {
  Writer big = TrainAvatar();
  big.arguments = [](const std::string& out) {
    return MadeAvatarTraining(out, 12, 150'000, {"--quiet", "--resume"});
  };
  big = Interrupted(big);
  Prepare(big);
  ASSERT_EQ(Run(big, {}).code, 0);
  whole_ = FilesOf(out_);
  const auto limit = [](size_t megabytes) {
    return "ulimit -c 0; ulimit -v " + std::to_string(megabytes << 10) + ";";
  };
  size_t start = 100;
  while (Cosplat({"--version"}, limit(start)).code != 0) start += 20;
  constexpr size_t kThreads = 100;  // for the threads' stacks: without them no thread starts
  size_t failed = 0;
  for (size_t megabytes = start + kThreads;; megabytes += 60) {
    Prepare(big);
    before_ = FilesOf(out_);
    const CommandResult result = Cosplat(big.arguments(out_), limit(megabytes));
    const std::string of = big.name + ", " + std::to_string(megabytes - start) + " MB";
    if (result.code == 0) {
      ExpectSameFiles(whole_, FilesOf(out_), of);
      break;
    }
    ++failed;
    EXPECT_EQ(result.code, 2) << of << ": " << result.err;
    EXPECT_EQ(result.err, "cosplat: out of memory\n") << of;
    ExpectNoHalves(of);
    ExpectGoesOn(big, of);
    ASSERT_LT(megabytes, 8000u);
  }
  EXPECT_GE(failed, 3u);
  std::printf("| `%s` | | %zu limits of memory (ulimit -v) | 2 | `cosplat: out of memory` |\n",
              big.name.c_str(),
              failed);
}

}  // namespace
}  // namespace cosplat::test
