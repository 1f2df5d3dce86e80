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

// In the child, where only async-signal-safe functions may be called: other threads held locks.
// Returns if the program could not be started, with the reason in errno.
void BecomeProgram(pid_t parent, int output, char* const* argv, char* const* environment) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (nothing < 0 || dup2(nothing, STDIN_FILENO) < 0) return;
  if (dup2(output, STDOUT_FILENO) < 0 || dup2(output, STDERR_FILENO) < 0) return;
  execve(argv[0], argv, environment);
}

int StatusOf(int wait_status) {
  return WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 128 + WTERMSIG(wait_status);
}

class Child {
 public:
  Child(const std::vector<std::string>& argv, const std::vector<std::string>& environment)
      : output_(argv[0]) {
    const std::vector<std::string> variables = Environment(environment);
    const std::vector<char*> arguments = Pointers(argv), settings = Pointers(variables);
    Pipe failure(argv[0]);
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ == 0) {
      BecomeProgram(parent, output_.write_end, arguments.data(), settings.data());
      const int reason = errno;
      _exit(write(failure.write_end, &reason, sizeof reason) < 0 ? 126 : 127);
    }
    int reason = pid_ < 0 ? errno : 0;
    failure.CloseWriteEnd();
    output_.CloseWriteEnd();
    const bool failed = pid_ < 0 || read(failure.read_end, &reason, sizeof reason) > 0;
    if (!failed) return;
    Wait();
    throw Error(argv[0], std::string("cannot be started: ") + std::strerror(reason));
  }

  ~Child() {
    if (pid_ <= 0) return;
    kill(pid_, SIGTERM);
    Wait();
  }

  // The lines, until the child has ended: what it started itself may keep the pipe open for longer.
  int PassOn(const std::function<void(const std::string& line)>& on_line) {
    bool open = true;
    while (true) {
      const bool ended = HasEnded();
      if (open) open = ReadAvailable(ended ? 0 : kPollMilliseconds, on_line);
      if (!ended && !open) Wait();
      if (ended || !open) break;
    }
    if (!line_.empty()) on_line(Plain(line_));
    return status_;
  }

 private:
  bool HasEnded() {
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) == 0) return false;
    pid_ = -1;
    status_ = StatusOf(status);
    return true;
  }

  void Wait() {
    int status = 0;
    while (pid_ > 0 && waitpid(pid_, &status, 0) < 0 && errno == EINTR) continue;
    pid_ = -1;
    status_ = StatusOf(status);
  }

  // Waits for output, and reads until there is none for now. Returns whether more may come.
  bool ReadAvailable(int milliseconds, const std::function<void(const std::string&)>& on_line) {
    pollfd output{output_.read_end, POLLIN, 0};
    while (poll(&output, 1, milliseconds) > 0) {
      char bytes[4096];
      const ssize_t count = read(output_.read_end, bytes, sizeof bytes);
      if (count <= 0) return count < 0 && errno == EINTR;
      for (ssize_t i = 0; i < count; ++i) Add(bytes[i], on_line);
    }
    return true;
  }

  void Add(char c, const std::function<void(const std::string&)>& on_line) {
    const bool end = c == '\n' || c == '\r';
    if (!end) line_ += c;
    if (line_.empty() || (!end && line_.size() < kMaxLine)) return;
    const std::string line = Plain(line_);
    line_.clear();
    on_line(line);
  }

  Pipe output_;
  pid_t pid_ = -1;
  int status_ = 0;
  std::string line_;  // read so far
};

}  // namespace

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
  Child child(argv, environment);
  return child.PassOn(on_line);
}

std::string ExitText(int status) {
  if (status <= 128) return "exited with status " + std::to_string(status);
  const int signal = status - 128;
  return "was killed by signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
}

}  // namespace cosplat
