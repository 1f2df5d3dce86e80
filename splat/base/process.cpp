#include "splat/base/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <future>
#include <mutex>
#include <sstream>
#include <thread>

#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr size_t kMaxLine = 1 << 16;  // longer ones are passed on in pieces
constexpr int kPollMilliseconds = 100;

bool IsExecutable(const std::string& path) {
  return std::filesystem::is_regular_file(path) && access(path.c_str(), X_OK) == 0;
}

std::vector<std::string> Environment(const std::vector<std::string>& additions) {
  std::vector<std::string> all = additions;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    const std::string name = text.substr(0, text.find('=') + 1);
    bool replaced = false;
    for (const std::string& addition : additions) replaced |= addition.starts_with(name);
    if (!replaced) all.push_back(text);
  }
  return all;
}

std::vector<char*> Pointers(const std::vector<std::string>& strings) {
  std::vector<char*> pointers;
  for (const std::string& s : strings) pointers.push_back(const_cast<char*>(s.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

// Without a terminal's control sequences ("\x1b[31m"), which programs write that take the pipe for
// one, or their log's colours for wanted.
std::string Plain(const std::string& line) {
  std::string plain;
  for (size_t i = 0; i < line.size(); ++i) {
    if (line.compare(i, 2, "\x1b[") != 0) {
      plain += line[i];
      continue;
    }
    i += 2;
    while (i < line.size() && (line[i] < 0x40 || line[i] > 0x7e)) ++i;
  }
  return plain;
}

// In the child, where only async-signal-safe functions may be called: other threads held locks.
// Returns if the program could not be started, with the reason in errno.
void BecomeProgram(
    bool reads_nothing, int output, int errors, char* const* argv, char* const* environment) {
  if (reads_nothing) {
    const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (nothing < 0 || dup2(nothing, STDIN_FILENO) < 0) return;
  }
  if (dup2(output, STDOUT_FILENO) < 0 || dup2(errors, STDERR_FILENO) < 0) return;
  execve(argv[0], argv, environment);
}

int StatusOf(int wait_status) {
  return WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 128 + WTERMSIG(wait_status);
}

// Closes both ends when it goes out of scope; the program that a child becomes has neither.
struct Pipe {
  int read_end = -1, write_end = -1;
  explicit Pipe(const std::string& program) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
      throw Error(program, std::string("cannot be started: ") + std::strerror(errno));
    read_end = ends[0];
    write_end = ends[1];
  }
  ~Pipe() {
    CloseWriteEnd();
    close(read_end);
  }
  void CloseWriteEnd() {
    if (write_end >= 0) close(write_end);
    write_end = -1;
  }
};

}  // namespace

// The child is of a thread that waits for it, since the kernel takes the end of the thread that
// started a child for its parent's.
struct ChildProcess::Running {
  explicit Running(const std::string& program) : output(program), errors(program) {}

  // Until the child has ended. `failure`: where a child that is no program says why.
  void Keep(const std::function<void()>& become, Pipe& failure, std::promise<int> started) {
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGTERM);
      if (getppid() != parent) _exit(1);
      become();
      const int reason = errno;
      _exit(write(failure.write_end, &reason, sizeof reason) < 0 ? 126 : 127);
    }
    int reason = child < 0 ? errno : 0;
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);  // they are for the program's own threads
    pid = child;
    failure.CloseWriteEnd();
    if (child > 0 && read(failure.read_end, &reason, sizeof reason) < 0) reason = errno;
    started.set_value(reason);
    if (child > 0) Reap();
    ended = true;
  }

  void Reap() {
    siginfo_t info;
    while (waitid(P_PID, id_t(pid), &info, WEXITED | WNOWAIT) < 0 && errno == EINTR) continue;
    const std::lock_guard lock(mutex);
    int wait_status = 0;
    if (waitpid(pid, &wait_status, 0) == pid) status = StatusOf(wait_status);
    pid = -1;
  }

  void End() {
    const std::lock_guard lock(mutex);
    if (pid > 0) kill(pid, SIGTERM);
  }

  Pipe output, errors;
  std::mutex mutex;  // of pid, which may be another process's once the child is waited for
  pid_t pid = -1;
  int status = 0;  // once it has ended
  std::atomic<bool> ended{false};
  std::thread keeper;
};

ChildProcess::ChildProcess(const std::vector<std::string>& argv,
                           const std::vector<std::string>& environment,
                           Errors errors,
                           Input input)
    : running_(std::make_unique<Running>(argv[0])) {
  Running& running = *running_;
  const std::vector<std::string> variables = Environment(environment);
  const std::vector<char*> arguments = Pointers(argv), settings = Pointers(variables);
  const int error_end = errors == Errors::kApart        ? running.errors.write_end
                        : errors == Errors::kWithOutput ? running.output.write_end
                                                        : STDERR_FILENO;
  const std::function<void()> become = [&] {
    BecomeProgram(input == Input::kNothing,
                  running.output.write_end,
                  error_end,
                  arguments.data(),
                  settings.data());
  };
  Pipe failure(argv[0]);
  std::promise<int> started;
  std::future<int> answer = started.get_future();
  running.keeper = std::thread([&, promise = std::move(started)]() mutable {
    running.Keep(become, failure, std::move(promise));
  });
  const int reason = answer.get();
  running.output.CloseWriteEnd();
  running.errors.CloseWriteEnd();
  if (reason == 0) return;
  Wait();
  throw Error(argv[0], std::string("cannot be started: ") + std::strerror(reason));
}

ChildProcess::~ChildProcess() {
  running_->End();
  Wait();
}

int ChildProcess::output() const { return running_->output.read_end; }
int ChildProcess::errors() const { return running_->errors.read_end; }
bool ChildProcess::HasEnded() const { return running_->ended; }

int ChildProcess::Wait() {
  if (running_->keeper.joinable()) running_->keeper.join();
  return running_->status;
}

OutputLines::OutputLines(int descriptor, std::function<void(const std::string& line)> use)
    : descriptor_(descriptor), use_(std::move(use)) {}

bool OutputLines::ReadAvailable(int milliseconds) {
  pollfd output{descriptor_, POLLIN, 0};
  while (poll(&output, 1, milliseconds) > 0) {
    char bytes[4096];
    const ssize_t count = read(descriptor_, bytes, sizeof bytes);
    if (count <= 0) return count < 0 && errno == EINTR;
    for (ssize_t i = 0; i < count; ++i) Add(bytes[i]);
  }
  return true;
}

void OutputLines::Finish() {
  if (!line_.empty()) use_(Plain(line_));
  line_.clear();
}

void OutputLines::Add(char c) {
  const bool end = c == '\n' || c == '\r';
  if (!end) line_ += c;
  if (line_.empty() || (!end && line_.size() < kMaxLine)) return;
  const std::string line = Plain(line_);
  line_.clear();
  use_(line);
}

std::string FindProgram(const std::string& name) {
  if (name.find('/') != std::string::npos) return IsExecutable(name) ? name : "";
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string file = (folder.empty() ? "." : folder) + "/" + name;
    if (IsExecutable(file)) return file;
  }
  return "";
}

std::string ThisProgram() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

int RunProcess(const std::vector<std::string>& argv,
               const std::vector<std::string>& environment,
               const std::function<void(const std::string& line)>& on_line) {
  ChildProcess child(argv, environment, ChildProcess::Errors::kWithOutput);
  OutputLines lines(child.output(), on_line);
  // Until the child has ended: what it started itself may keep the pipe open for longer.
  for (bool open = true, ended = false; open && !ended;) {
    ended = child.HasEnded();
    open = lines.ReadAvailable(ended ? 0 : kPollMilliseconds);
  }
  lines.Finish();
  return child.Wait();
}

std::string ExitText(int status) {
  if (status <= 128) return "exited with status " + std::to_string(status);
  const int signal = status - 128;
  return "was killed by signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
}

}  // namespace cosplat
