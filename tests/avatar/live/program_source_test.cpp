// "webcam:" and "audio:" of any host, with a script in the place of the command cosplat.
#include <gtest/gtest.h>
#include <signal.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include "avatar/live/source.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;

constexpr const char* kFrame = R"({"seq": 1, "blendshapes": {"jawOpen": 0.5}})";

struct Command {
  test::TemporaryFolder folder;
  LiveSourceOptions options;
  explicit Command(const std::string& script) {
    options.program = folder / "cosplat";
    std::ofstream(options.program) << "#!/bin/sh\ncd '" << (folder / "") << "'\n" << script << "\n";
    std::filesystem::permissions(options.program, std::filesystem::perms::owner_all);
  }
  std::string Read(const std::string& name) const {
    std::string line;
    std::getline(std::ifstream(folder / name), line);
    return line;
  }
};

bool Until(const std::function<bool()>& done) {
  for (int i = 0; i < 1000; ++i) {
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

bool Delivers(LiveSource& source, LiveFrame& frame) {
  return Until([&] { return source.Poll(0, frame); });
}

TEST(ProgramSource, RunsTheCommandOfTheDrive) {
  const Command command(std::string("echo \"$@\" >said; echo '") + kFrame + "'; exec sleep 60");
  const std::pair<const char*, const char*> drives[] = {{"webcam:", "webcam"},
                                                        {"webcam:1", "webcam --camera 1"},
                                                        {"audio:", "voice"},
                                                        {"audio:-", "voice -"}};
  for (const auto& [drive, said] : drives) {
    EXPECT_TRUE(IsLiveDrive(drive));
    const auto source = OpenLiveSource(drive, command.options);
    LiveFrame frame;
    ASSERT_TRUE(Delivers(*source, frame)) << drive;
    EXPECT_GT(frame.params.pose[2][0], 0.01f);
    EXPECT_EQ(command.Read("said"), said);
    EXPECT_EQ(source->Description(), drive);
    EXPECT_FALSE(source->Ended());
  }
}

TEST(ProgramSource, TheCommandOutlivesTheThreadThatOpensIt) {
  const Command command(std::string("echo $$ >pid; sleep .3; echo '") + kFrame +
                        "'; exec sleep 60");
  std::unique_ptr<LiveSource> source;
  std::thread([&] { source = OpenLiveSource("webcam:", command.options); }).join();
  LiveFrame frame;
  ASSERT_TRUE(Delivers(*source, frame));
  const pid_t pid = std::stoi(command.Read("pid"));
  EXPECT_EQ(kill(pid, 0), 0);
  source.reset();
  EXPECT_TRUE(kill(pid, 0) != 0 && errno == ESRCH) << "it goes with the source";
}

TEST(ProgramSource, WhyItEndedIsTheLastProblem) {
  const auto problem = [](const std::string& script) {
    const Command command(script);
    const auto source = OpenLiveSource("webcam:", command.options);
    LiveFrame frame;
    EXPECT_TRUE(Until([&] {
      source->Poll(0, frame);
      return source->Ended();
    }));
    return source->Counts().last_problem;
  };
  EXPECT_EQ(problem("echo 'cosplat: camera 0: is in use' >&2; exit 2"),
            "cosplat: camera 0: is in use");
  EXPECT_EQ(problem("echo '30 frames/s' >&2; kill -9 $$"),
            "webcam:: was killed by signal 9 (Killed)");
  EXPECT_EQ(problem("exit 3"), "webcam:: exited with status 3");
  EXPECT_EQ(problem("exit 0"), "");
}

TEST(ProgramSource, WithoutTheCommandTheDriveSaysSo) {
  LiveSourceOptions options;
  options.program = "/no/cosplat";
  ExpectError([&] { OpenLiveSource("audio:", options); }, {"audio:", "/no/cosplat"});
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/no", 1);
  ExpectError([&] { OpenLiveSource("webcam:"); }, {"webcam:", "cosplat in PATH"});
  setenv("PATH", path.c_str(), 1);
}

TEST(ProgramSource, ASoundFileIsARecordingToBeMadeFirst) {
  ExpectError([] { OpenLiveSource("audio:talk.wav"); },
              {"audio:talk.wav", "cosplat voice FILE -o"});
}

}  // namespace
}  // namespace cosplat
