// Child processes: output, exit status, environment, and that none stays behind.
#include "splat/base/process.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "splat/base/error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using Lines = std::vector<std::string>;

int Shell(const std::string& script, Lines& lines, const Lines& environment = {}) {
  return RunProcess({"/bin/sh", "-c", script}, environment, [&](const std::string& line) {
    lines.push_back(line);
  });
}

// Whether the process is gone, or is a zombie that nobody waits for.
bool IsOver(pid_t pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string number, name, state;
  return !(stat >> number >> name >> state) || state == "Z";
}

bool Ends(pid_t pid) {
  for (int i = 0; i < 500; ++i) {
    if (IsOver(pid)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

TEST(Process, PassesOnBothOutputsByTheLine) {
  Lines lines;
  EXPECT_EQ(Shell("echo one; echo two >&2; printf '10%%\\r20%%\\r'; printf last", lines), 0);
  EXPECT_EQ(lines, (Lines{"one", "two", "10%", "20%", "last"}));
}

TEST(Process, ReturnsTheStatusOrTheSignal) {
  Lines lines;
  EXPECT_EQ(Shell("exit 3", lines), 3);
  EXPECT_EQ(Shell("kill -9 $$", lines), 128 + 9);
  EXPECT_EQ(ExitText(3), "exited with status 3");
  EXPECT_EQ(ExitText(128 + 9), "was killed by signal 9 (Killed)");
}

TEST(Process, PassesArgumentsWithoutAShell) {
  Lines lines;
  const std::string odd = "a b'\"$HOME;`ls`*";
  RunProcess({"/bin/sh", "-c", "printf '%s\\n' \"$1\"", "sh", odd}, {}, [&](const auto& line) {
    lines.push_back(line);
  });
  EXPECT_EQ(lines, Lines{odd});
}

TEST(Process, SetsVariablesBesideThoseThatAreThere) {
  ASSERT_EQ(setenv("COSPLAT_TEST_KEPT", "kept", 1), 0);
  ASSERT_EQ(setenv("COSPLAT_TEST_SET", "before", 1), 0);
  Lines lines;
  Shell("echo $COSPLAT_TEST_KEPT $COSPLAT_TEST_SET", lines, {"COSPLAT_TEST_SET=after"});
  EXPECT_EQ(lines, Lines{"kept after"});
}

TEST(Process, ReadsNothing) {
  Lines lines;
  EXPECT_EQ(Shell("cat; echo done", lines), 0);
  EXPECT_EQ(lines, Lines{"done"});
}

TEST(Process, DoesNotWaitForWhatTheChildLeavesBehind) {
  Lines lines;
  EXPECT_EQ(Shell("sleep 60 & echo $!", lines), 0);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(kill(std::stoi(lines[0]), SIGKILL), 0);  // it still ran
}

TEST(Process, OneThatIsNoProgramIsAnError) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "text") << "no program\n";
  std::filesystem::permissions(folder / "text", std::filesystem::perms::owner_all);
  EXPECT_THROW(RunProcess({folder / "text"}, {}, [](const auto&) {}), Error);
  EXPECT_THROW(RunProcess({folder / "absent"}, {}, [](const auto&) {}), Error);
}

TEST(Process, TheChildEndsIfALineIsRefused) {
  pid_t pid = 0;
  EXPECT_THROW(RunProcess({"/bin/sh", "-c", "echo $$; exec sleep 60"},
                          {},
                          [&](const std::string& line) {
                            pid = std::stoi(line);
                            throw Error("line", "refused");
                          }),
               Error);
  EXPECT_TRUE(Ends(pid));
}

TEST(Process, TheChildEndsWithThisProcess) {
  const test::TemporaryFolder folder;
  const std::string file = folder / "pid";
  const pid_t parent = fork();
  if (parent == 0) {
    RunProcess({"/bin/sh", "-c", "echo $$ >'" + file + "'; echo ready; exec sleep 60"},
               {},
               [](const auto&) { raise(SIGKILL); });
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(parent, &status, 0), parent);
  EXPECT_EQ(WTERMSIG(status), SIGKILL);
  pid_t child = 0;
  ASSERT_TRUE(std::ifstream(file) >> child);
  EXPECT_TRUE(Ends(child));
}

TEST(Process, FindsProgramsInThePath) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "tool") << "#!/bin/sh\n";
  const std::string before = std::getenv("PATH");
  setenv("PATH", ("/absent:" + (folder / "") + ":" + before).c_str(), 1);
  EXPECT_EQ(FindProgram("tool"), "");  // not executable
  std::filesystem::permissions(folder / "tool", std::filesystem::perms::owner_all);
  EXPECT_TRUE(std::filesystem::equivalent(FindProgram("tool"), folder / "tool"));
  setenv("PATH", before.c_str(), 1);
  EXPECT_EQ(FindProgram("tool"), "");
  EXPECT_EQ(FindProgram(folder / "tool"), folder / "tool");
  EXPECT_EQ(FindProgram(folder / ""), "");
}

}  // namespace
}  // namespace cosplat
