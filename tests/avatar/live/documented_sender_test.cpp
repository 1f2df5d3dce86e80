// The senders that docs/live-input.md shows, run as they stand there.
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <string>
#include <vector>

#include "avatar/live/source.h"
#include "splat/base/files.h"
#include "tests/support/temporary_folder.h"

extern char** environ;

namespace cosplat {
namespace {

using test::TemporaryFolder;

// The page's block of Python that contains `word`.
std::string DocumentedPython(const std::string& word) {
  const std::vector<char> bytes = ReadFile(COSPLAT_SOURCE_DIR "/docs/live-input.md");
  const std::string page(bytes.begin(), bytes.end()), fence = "```python\n";
  for (size_t at = 0; (at = page.find(fence, at)) != std::string::npos;) {
    at += fence.size();
    const std::string block = page.substr(at, page.find("```", at) - at);
    if (block.find(word) != std::string::npos) return block;
  }
  return "";
}

// A child process that ends with the object.
class Child {
 public:
  explicit Child(std::vector<std::string> arguments) {
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    if (posix_spawnp(&id_, argv[0], nullptr, nullptr, argv.data(), environ) != 0) id_ = -1;
  }
  ~Child() {
    if (id_ < 0) return;
    kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
  }
  bool started() const { return id_ >= 0; }

 private:
  pid_t id_ = -1;
};

// Polls as a player at 100 frames per second would, for ten seconds at most.
bool WaitForFrame(LiveSource& source, LiveFrame& frame) {
  for (int i = 0; i < 1000; ++i) {
    if (source.Poll(int64_t(i) * 10'000'000, frame)) return true;
    poll(nullptr, 0, 10);
  }
  return false;
}

TEST(DocumentedSender, OfJsonWorksAsItStands) {
  const std::string text = DocumentedPython("json.dumps");
  ASSERT_FALSE(text.empty());
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "sender.py", text);
  const auto source = OpenLiveSource("udp://:0");
  const std::string description = source->Description();
  const Child sender(
      {"python3", folder / "sender.py", description.substr(description.rfind(':') + 1)});
  if (!sender.started()) GTEST_SKIP() << "no python3";
  LiveFrame frame;
  for (uint64_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(WaitForFrame(*source, frame)) << source->Counts().last_problem;
    EXPECT_GE(frame.sequence, i);
    EXPECT_GE(frame.params.pose[2][0], 0);
    EXPECT_LE(frame.params.pose[2][0], 0.2f);
  }
  EXPECT_EQ(source->Counts().last_problem, "");
}

}  // namespace
}  // namespace cosplat
