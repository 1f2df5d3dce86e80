#include "apps/cosplat/run/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>

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
void BecomeProgram(pid_t parent,
                   bool reads_nothing,
                   int output,
                   int errors,
                   char* const* argv,
                   char* const* environment) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
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

// The lines of a child's output as they come.
class Lines {
 public:
  Lines(int descriptor, const std::function<void(const std::string& line)>& use)
      : descriptor_(descriptor), use_(use) {}

  // Waits for output, and reads until there is none for now. Returns whether more may come.
  bool ReadAvailable(int milliseconds) {
    pollfd output{descriptor_, POLLIN, 0};
    while (poll(&output, 1, milliseconds) > 0) {
      char bytes[4096];
      const ssize_t count = read(descriptor_, bytes, sizeof bytes);
      if (count <= 0) return count < 0 && errno == EINTR;
      for (ssize_t i = 0; i < count; ++i) Add(bytes[i]);
    }
    return true;
  }
  // What is left, without an end.
  void Finish() {
    if (!line_.empty()) use_(Plain(line_));
  }

 private:
  void Add(char c) {
    const bool end = c == '\n' || c == '\r';
    if (!end) line_ += c;
    if (line_.empty() || (!end && line_.size() < kMaxLine)) return;
    const std::string line = Plain(line_);
    line_.clear();
    use_(line);
  }

  int descriptor_;
  const std::function<void(const std::string& line)>& use_;
  std::string line_;  // read so far
};

}  // namespace

struct ChildProcess::Running {
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

  explicit Running(const std::string& program) : output(program) {}
  Pipe output;
  pid_t pid = -1;
  int status = 0;
};

ChildProcess::ChildProcess(const std::vector<std::string>& argv,
                           const std::vector<std::string>& environment,
                           Errors errors,
                           Input input)
    : running_(std::make_unique<Running>(argv[0])) {
  using Pipe = Running::Pipe;
  Pipe& output = running_->output;
  const std::vector<std::string> variables = Environment(environment);
  const std::vector<char*> arguments = Pointers(argv), settings = Pointers(variables);
  Pipe failure(argv[0]);
  const pid_t parent = getpid();
  const pid_t pid = running_->pid = fork();
  if (pid == 0) {
    BecomeProgram(parent,
                  input == Input::kNothing,
                  output.write_end,
                  errors == Errors::kWithOutput ? output.write_end : STDERR_FILENO,
                  arguments.data(),
                  settings.data());
    const int reason = errno;
    _exit(write(failure.write_end, &reason, sizeof reason) < 0 ? 126 : 127);
  }
  int reason = pid < 0 ? errno : 0;
  failure.CloseWriteEnd();
  output.CloseWriteEnd();
  const bool failed = pid < 0 || read(failure.read_end, &reason, sizeof reason) > 0;
  if (!failed) return;
  Wait();
  throw Error(argv[0], std::string("cannot be started: ") + std::strerror(reason));
}

ChildProcess::~ChildProcess() {
  if (running_->pid <= 0) return;
  kill(running_->pid, SIGTERM);
  Wait();
}

int ChildProcess::output() const { return running_->output.read_end; }
int ChildProcess::status() const { return running_->status; }

bool ChildProcess::HasEnded() {
  int status = 0;
  if (running_->pid > 0 && waitpid(running_->pid, &status, WNOHANG) == 0) return false;
  if (running_->pid > 0) running_->status = StatusOf(status);
  running_->pid = -1;
  return true;
}

int ChildProcess::Wait() {
  int status = 0;
  pid_t& pid = running_->pid;
  if (pid <= 0) return running_->status;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;
  pid = -1;
  return running_->status = StatusOf(status);
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

int RunProcess(const std::vector<std::string>& argv,
               const std::vector<std::string>& environment,
               const std::function<void(const std::string& line)>& on_line) {
  ChildProcess child(argv, environment, ChildProcess::Errors::kWithOutput);
  Lines lines(child.output(), on_line);
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
