// The sender that docs/live-input.md shows, run as it stands there.
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <memory>
#include <string>
#include <vector>

#include "avatar/live/source.h"
#include "splat/base/files.h"
#include "tests/avatar/live/osc_builder.h"
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

// Runs the page's sender that contains a word, its argument the port that `source` listens to.
class DocumentedSender : public testing::Test {
 protected:
  void Start(const std::string& word, const LiveSource& source) {
    const std::string text = DocumentedPython(word);
    ASSERT_FALSE(text.empty());
    WriteFileAtomically(folder_ / "sender.py", text);
    const std::string address = test::AddressOf(source);
    const std::string port = address.substr(address.rfind(':') + 1);
    sender_ =
        std::make_unique<Child>(std::vector<std::string>{"python3", folder_ / "sender.py", port});
    if (!sender_->started()) GTEST_SKIP() << "no python3";
  }
  // Three frames, with the jaw between shut and open.
  void ExpectFrames(LiveSource& source, float open) {
    LiveFrame frame;
    for (uint64_t i = 0; i < 3 && !IsSkipped(); ++i) {
      ASSERT_TRUE(WaitForFrame(source, frame)) << source.Counts().last_problem;
      EXPECT_GE(frame.sequence, i);
      EXPECT_GE(frame.params.pose[2][0], 0);
      EXPECT_LE(frame.params.pose[2][0], open);
    }
    EXPECT_EQ(source.Counts().last_problem, "");
  }

  const TemporaryFolder folder_;

 private:
  std::unique_ptr<Child> sender_;
};

TEST_F(DocumentedSender, OfJsonWorksAsItStands) {
  const auto source = OpenLiveSource("udp://:0");
  Start("json.dumps", *source);
  ExpectFrames(*source, 0.2f);
}

}  // namespace
}  // namespace cosplat
